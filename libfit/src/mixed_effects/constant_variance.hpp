// SPDX-License-Identifier: MIT
// Whether a variance function has a constant variance as a special case.
#pragma once

#include <algorithm>

#include "silvafit/fit/variance_function.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {

/// Whether a factor can be the same for all observations.
inline bool contains_constant(const VarianceFactor& factor) {
  const bool has_exponent = kind_of(factor).has_delta() && factor.delta && *factor.delta != 0.0;
  // The power vanishes beside a large constant.
  return !has_exponent || (kind_of(factor).has_constant() && !factor.constant);
}

/// Whether a constant variance is a special case of this function.
inline bool contains_constant(const VarianceFunction& function) {
  return std::ranges::all_of(
      function.factors, [](const VarianceFactor& factor) { return contains_constant(factor); });
}

}  // namespace silvafit::fit
