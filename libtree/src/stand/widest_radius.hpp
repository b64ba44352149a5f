// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "silvafit/tree/crown.hpp"

namespace silvafit::tree {

/// The longest of the four radii of a crown [m].
inline double widest_radius_m(const CrownRadii& radii) {
  return std::max({radii.east_m, radii.west_m, radii.south_m, radii.north_m});
}

}  // namespace silvafit::tree
