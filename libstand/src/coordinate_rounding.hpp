// SPDX-License-Identifier: MIT
// How far the rounding of coordinates moves what is computed from them.
#pragma once

#include <limits>

namespace silvafit::stand {

/// How far apart rounding may put two places that are one [m]: 4 units in the last place of the
/// coordinates, since one computed from others, as x/10 is, may be off by some.
/// \param farthest_m  the largest coordinate, without its sign
constexpr double coordinate_rounding_m(double farthest_m) {
  return 4.0 * std::numeric_limits<double>::epsilon() * farthest_m;
}

}  // namespace silvafit::stand
