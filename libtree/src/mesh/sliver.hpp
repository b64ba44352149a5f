// SPDX-License-Identifier: MIT
// Degenerate triangles.
#pragma once

#include <algorithm>

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Whether a triangle is so small or so narrow that floats cannot distinguish its sides.
/// \param face  cross product of its sides `ab` and `ac`
inline bool is_sliver(Point ab, Point ac, Point face) {
  constexpr double kSmallest = 1e-8;  // m2
  constexpr double kNarrowest = 2e-5;
  const double least = std::max(kSmallest, kNarrowest * (dot(ab, ab) + dot(ac, ac)));
  return dot(face, face) < least * least;
}

}  // namespace silvafit::tree
