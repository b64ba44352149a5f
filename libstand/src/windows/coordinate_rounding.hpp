// SPDX-License-Identifier: MIT
// The effect of coordinate rounding on computed values.
#pragma once

#include <limits>

namespace silvafit::stand {

/// The largest distance that rounding may put between two equal positions [m]: 4 units in the last
/// place of the coordinates, because computed coordinates, such as x/10, may have several errors.
/// \param farthest_m  the largest absolute coordinate
constexpr double coordinate_rounding_m(double farthest_m) {
  return 4.0 * std::numeric_limits<double>::epsilon() * farthest_m;
}

}  // namespace silvafit::stand
