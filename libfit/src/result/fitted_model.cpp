// SPDX-License-Identifier: MIT
#include "silvafit/fit/fitted_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
bool is_mixed(Method method) {
  return method != Method::kOrdinary && method != Method::kGeneralized;
}

bool is_marginal(Method method) { return is_mixed(method) && method != Method::kLindstromBates; }

Method default_method(const ModelSpecification& specification) {
  if (!specification.random.empty()) return Method::kLindstromBates;
  const bool is_simple = specification.variance.is_constant() && !specification.correlation;
  return is_simple ? Method::kOrdinary : Method::kGeneralized;
}

bool FittedModel::knows_uncertainty() const {
  const bool lacks_cells = random.size() > 1 && cells.groups.empty();
  return has_random_effects() && random.back().uncertainty.is_known() && !lacks_cells;
}

double FittedModel::bic_groups() const {
  const std::vector<RandomEffects>& terms = specification.random;
  const auto is_within_first = [&terms](const RandomEffects& term) {
    return &term == &terms.front() ||
           (!term.within.empty() && term.within.front() == terms.front().group);
  };
  const bool are_independent = !are_crossed(terms) || std::ranges::all_of(terms, is_within_first);
  return are_independent ? Estimates::bic_groups() : kNaN;
}

VectorXd FittedModel::residual_sd(const Eigen::Ref<const VectorXd>& fitted,
                                  const data::Table& table) const {
  return sigma * relative_sd(variance, fitted, table);
}

MatrixXd fixed_covariance(const FittedModel& fit) {
  const Index p = fit.estimate.size();
  MatrixXd result = fit.covariance.rows() == p ? fit.covariance : MatrixXd::Zero(p, p);
  for (Index j = 0; j < p; ++j) {
    const bool is_estimated =
        j < fit.degrees_of_freedom.size() && std::isfinite(fit.degrees_of_freedom[j]);
    if (is_estimated || !std::isnan(result(j, j))) continue;
    result.row(j).setZero();
    result.col(j).setZero();
  }
  return result;
}

}  // namespace silvafit::fit
