// SPDX-License-Identifier: MIT
#include "inference/comparable_likelihoods.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace silvafit::fit {
namespace {

bool has_same_fixed_effects(const FittedModel& a, const FittedModel& b) {
  return a.specification.formula.right.text() == b.specification.formula.right.text() &&
         a.coefficient_names == b.coefficient_names;
}

}  // namespace

bool is_at_bound(const FittedModel& fit, const std::string& coefficient) {
  return fit.convergence.has(Evidence::Kind::kLowerBound, coefficient) ||
         fit.convergence.has(Evidence::Kind::kUpperBound, coefficient);
}

int count_without_bounded(const FittedModel& fit) {
  const auto bounded = std::ranges::count_if(
      fit.coefficient_names, [&](const std::string& name) { return is_at_bound(fit, name); });
  return std::max(0, fit.parameter_count - static_cast<int>(bounded));
}

bool has_usable_likelihood(const FittedModel& fit) {
  return fit.convergence.converged() && std::isfinite(fit.log_likelihood);
}

std::string obstacle_to_comparing(const FittedModel& a, const FittedModel& b) {
  if (a.observations != b.observations) {
    return fmt::format("the fits have {} and {} observations", a.observations, b.observations);
  }
  if (a.specification.formula.left != b.specification.formula.left) {
    return fmt::format("the responses differ: {} and {}",
                       a.specification.formula.left,
                       b.specification.formula.left);
  }
  const bool is_known = !a.response_fingerprint.empty() && !b.response_fingerprint.empty();
  if (is_known && a.response_fingerprint != b.response_fingerprint) {
    return "the fits use different observations of the response";
  }
  // Without random effects all methods have the same likelihood.
  const bool is_one_method = a.method == b.method && a.quadrature_points == b.quadrature_points;
  if (is_mixed(a.method) && is_mixed(b.method) && !is_one_method) {
    return a.method == b.method
               ? std::string("the likelihoods use different numbers of quadrature points")
               : fmt::format("the likelihoods of {} and {} are different approximations",
                             word_of(a.method),
                             word_of(b.method));
  }
  if (a.reml != b.reml) {
    return "one fit is by REML, the other by ML";
  }
  if (a.reml && !has_same_fixed_effects(a, b)) {
    return "REML likelihoods of models with different fixed effects cannot be compared; fit both "
           "by ML";
  }
  return {};
}

}  // namespace silvafit::fit
