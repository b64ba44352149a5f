// SPDX-License-Identifier: MIT
#include "inference/coefficients_at_bounds.hpp"

#include <algorithm>

namespace silvafit::fit {

bool is_at_bound(const FittedModel& fit, const std::string& coefficient) {
  return fit.convergence.has(Evidence::Kind::kLowerBound, coefficient) ||
         fit.convergence.has(Evidence::Kind::kUpperBound, coefficient);
}

int count_without_bounded(const FittedModel& fit) {
  const auto bounded = std::ranges::count_if(
      fit.coefficient_names, [&](const std::string& name) { return is_at_bound(fit, name); });
  return std::max(0, fit.parameter_count - static_cast<int>(bounded));
}

}  // namespace silvafit::fit
