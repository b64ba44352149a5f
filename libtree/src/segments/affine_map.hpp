// SPDX-License-Identifier: MIT
// Affine maps of space.
#pragma once

#include <array>

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// The map x -> A x + b of space.
struct AffineMap {
  std::array<std::array<double, 3>, 3> a{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< by row
  Point b{};

  Point operator()(Point x) const;
  /// A x, without b: the image of a direction.
  Point turn(Point x) const;
  /// The composition: first `other`, then this map.
  AffineMap after(const AffineMap& first) const;

  double determinant() const;
  /// The largest factor by which the map stretches a vector: the largest singular value of A.
  double spectral_norm() const;
};

/// A rotation about an axis through the origin, counterclockwise if it points to the viewer.
AffineMap turn_about(Point axis, double angle_rad);
/// The map with A multiplied by a number and the same b.
AffineMap scaled(const AffineMap& map, double factor);

}  // namespace silvafit::tree
