// SPDX-License-Identifier: MIT
#include "mixed_effects/degrees_of_freedom.hpp"

#include <algorithm>
#include <vector>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Differences that are smaller relative to the column's largest value are rounding errors.
constexpr double kEqualValues = 1e-10;
// nlme's own tolerance for a column that is constant in all data.
constexpr double kConstant = 1.5e-8;

/// First rows of the groups of one grouping, and the end.
using Cuts = std::vector<Index>;

/// The groupings from the coarsest to the finest.
std::vector<Cuts> groupings(const NonlinearModel& model) {
  std::vector<Cuts> result;
  if (model.specification().random.empty()) return result;
  if (model.specification().random.size() > 1) {
    Cuts& cuts = result.emplace_back();
    for (Index c = 0; c <= model.cluster_count(); ++c) {
      cuts.push_back(model.group_begin(model.cluster_begin(c)));
    }
  }
  Cuts& cuts = result.emplace_back();
  for (Index g = 0; g <= model.group_count(); ++g) cuts.push_back(model.group_begin(g));
  return result;
}

bool is_constant(const Eigen::Ref<const VectorXd>& column) {
  const double first = column[0];
  if (first == 0.0) return (column.array().abs() < kConstant).all();
  return ((column.array() / first - 1.0).abs() < kConstant).all();
}

bool varies_within(const Eigen::Ref<const VectorXd>& column, const Cuts& cuts) {
  const double tolerance = kEqualValues * column.cwiseAbs().maxCoeff();
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const auto rows = column.segment(cuts[k], cuts[k + 1] - cuts[k]);
    if (rows.maxCoeff() - rows.minCoeff() > tolerance) return true;
  }
  return false;
}

/// The finest stratum in which a column varies: 0 is between the coarsest groups.
std::size_t stratum_of(const Eigen::Ref<const VectorXd>& column, const std::vector<Cuts>& levels) {
  for (std::size_t level = levels.size(); level > 0; --level) {
    if (varies_within(column, levels[level - 1])) return level;
  }
  return 0;
}

}  // namespace

FixedFreedom fixed_freedom(const NonlinearModel& model,
                           const Eigen::Ref<const MatrixXd>& jacobian,
                           const std::vector<double>& units) {
  const std::vector<Cuts> levels = groupings(model);
  const auto n = units.empty() ? static_cast<double>(model.observations()) : units.back();
  const auto p = static_cast<double>(jacobian.cols());
  if (levels.empty()) return {.of_tests = VectorXd::Constant(jacobian.cols(), n - p)};
  std::vector<double> freedom;
  double above = 0.0;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const auto count = units.empty() ? static_cast<double>(levels[level].size() - 1) : units[level];
    freedom.push_back(count - above);
    above = count;
  }
  freedom.push_back(n - above);

  constexpr std::size_t kIntercept = 99;
  std::vector<std::size_t> strata;
  for (Index j = 0; j < jacobian.cols(); ++j) {
    strata.push_back(is_constant(jacobian.col(j)) ? kIntercept
                                                  : stratum_of(jacobian.col(j), levels));
    if (strata.back() != kIntercept) freedom[strata.back()] -= 1.0;
  }
  if (std::ranges::find(strata, kIntercept) != strata.end()) {
    freedom.front() -= 1.0;
  } else {
    for (std::size_t level = 1; level < freedom.size(); ++level) freedom[level] += 1.0;
  }
  FixedFreedom result{.of_tests = VectorXd(jacobian.cols())};
  for (Index j = 0; j < result.of_tests.size(); ++j) {
    const std::size_t stratum = strata[static_cast<std::size_t>(j)];
    result.of_tests[j] = stratum == kIntercept ? std::ranges::max(freedom) : freedom[stratum];
  }
  for (std::size_t level = 0; level < levels.size(); ++level) {
    result.coefficients_between.push_back(static_cast<int>(std::ranges::count(strata, level)));
  }
  return result;
}

FixedFreedom fixed_freedom_at(const NonlinearModel& model,
                              const VectorXd& coefficients,
                              const std::vector<double>& units) {
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  MatrixXd jacobian;
  model.evaluate(coefficients, mean, &jacobian, workspace);
  return fixed_freedom(model, jacobian, units);
}

}  // namespace silvafit::fit
