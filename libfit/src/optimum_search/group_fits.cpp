// SPDX-License-Identifier: MIT
#include "optimum_search/group_fits.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "least_squares/levenberg_marquardt.hpp"
#include "least_squares/variable_projection.hpp"
#include "mixed_effects/medians.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Groups with some observations more than parameters, thinned to a bounded number.
std::vector<Index> groups_to_fit(const NonlinearModel& model, Index parameters) {
  constexpr std::size_t kMostGroups = 40;
  std::vector<Index> groups;
  for (Index g = 0; g < model.group_count(); ++g) {
    if (model.group_begin(g + 1) - model.group_begin(g) > parameters) groups.push_back(g);
  }
  if (groups.size() <= kMostGroups) return groups;
  std::vector<Index> chosen;
  for (std::size_t k = 0; k < kMostGroups; ++k) {
    chosen.push_back(groups[k * groups.size() / kMostGroups]);
  }
  return chosen;
}

/// Observations of a group, thinned to the number that a curve needs.
std::vector<Index> rows_of(const NonlinearModel& model, Index group) {
  constexpr Index kMostRows = 200;
  const Index begin = model.group_begin(group);
  const Index count = model.group_begin(group + 1) - begin;
  const Index taken = std::min(count, kMostRows);
  std::vector<Index> rows;
  for (Index k = 0; k < taken; ++k) rows.push_back(begin + k * count / taken);
  return rows;
}

/// (K) typical values of the parameters at given coefficients: their means over the observations.
VectorXd mean_parameters(const NonlinearModel& model, const VectorXd& coefficients, Index count) {
  VectorXd result = VectorXd::Zero(count);
  for (Index j = 0; j < coefficients.size(); ++j) {
    result[model.parameter_of(j)] += coefficients[j] * model.multiplier(j).mean();
  }
  return result;
}

}  // namespace

std::optional<VectorXd> medians_of_group_fits(const NonlinearModel& model,
                                              const NonlinearModel& constants,
                                              const VectorXd& pooled) {
  constexpr std::size_t kFewest = 3;
  const Index count = constants.coefficient_count();
  const VectorXd start = mean_parameters(model, pooled, count);
  std::vector<std::vector<double>> values(static_cast<std::size_t>(count));
  for (const Index group : groups_to_fit(model, count)) {
    const NonlinearModel part = constants.subset(rows_of(model, group));
    ProjectedModel projected(part);
    const Descent descent = descend(
        projected, projected.nonlinear_part(start), {.maximum_iterations = 50, .tolerance = 1e-9});
    if (descent.coefficients.size() == 0 || !descent.coefficients.allFinite()) continue;
    for (Index j = 0; j < count; ++j) {
      values[static_cast<std::size_t>(j)].push_back(descent.coefficients[j]);
    }
  }
  if (count == 0 || values.front().size() < kFewest) return std::nullopt;
  return medians(std::move(values));
}

}  // namespace silvafit::fit
