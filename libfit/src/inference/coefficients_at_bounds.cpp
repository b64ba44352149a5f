// SPDX-License-Identifier: MIT
#include "inference/coefficients_at_bounds.hpp"

#include <algorithm>

namespace silvafit::fit {

bool is_at_bound(const FittedModel& fit, const std::string& coefficient) {
  // "a = 4, its lower bound"; "sd(a) = 0" is of a random effect.
  return std::ranges::any_of(fit.convergence.boundary, [&](const std::string& words) {
    return words.starts_with(coefficient + " = ") && words.ends_with(" bound");
  });
}

int count_without_bounded(const FittedModel& fit) {
  const auto bounded = std::ranges::count_if(
      fit.coefficient_names, [&](const std::string& name) { return is_at_bound(fit, name); });
  return std::max(0, fit.parameter_count - static_cast<int>(bounded));
}

}  // namespace silvafit::fit
