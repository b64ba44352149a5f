// SPDX-License-Identifier: MIT
// The regular polygons that represent round sections.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Directions of a regular polygon's corners in the plane (x, y).
inline std::vector<Point> corners(int sides) {
  std::vector<Point> result;
  result.reserve(static_cast<std::size_t>(sides));
  for (int i = 0; i < sides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / sides;
    result.push_back({std::cos(angle), std::sin(angle), 0.0});
  }
  return result;
}

/// Distance of the corners of the regular polygon with the area of the unit circle.
inline double equal_area_corner(int sides) {
  const double angle = 2.0 * std::numbers::pi / sides;
  return std::sqrt(angle / std::sin(angle));
}

}  // namespace silvafit::tree
