// SPDX-License-Identifier: MIT
#include "model/group_coefficients.hpp"

#include <vector>

#include "model/group_labels.hpp"

namespace silvafit::fit {
using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd coefficient_effects(const FittedModel& fit, const NonlinearModel& model) {
  MatrixXd result = MatrixXd::Zero(model.coefficient_count(), model.group_count());
  if (!fit.has_random_effects()) return result;
  const std::vector<Index> inner = model.coefficients_of(fit.specification.random);
  const auto inner_number = numbered(fit.group_labels);
  for (Index g = 0; g < model.group_count(); ++g) {
    const auto found = inner_number.find(model.group_labels()[static_cast<std::size_t>(g)]);
    if (found != inner_number.end()) result(inner, g) += fit.random_effects.col(found->second);
  }
  const std::vector<Index> outer = model.coefficients_of(fit.specification.outer_random);
  if (outer.empty()) return result;
  const auto outer_number = numbered(fit.outer.labels);
  for (Index c = 0; c < model.cluster_count(); ++c) {
    const auto found = outer_number.find(model.outer_labels()[static_cast<std::size_t>(c)]);
    if (found == outer_number.end()) continue;
    for (Index g = model.cluster_begin(c); g < model.cluster_begin(c + 1); ++g) {
      result(outer, g) += fit.outer.effects.col(found->second);
    }
  }
  return result;
}

}  // namespace silvafit::fit
