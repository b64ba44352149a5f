// SPDX-License-Identifier: MIT
// Maps of space that keep lines straight.
#pragma once

#include <array>

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// The map x -> A x + b of space.
struct AffineMap {
  std::array<std::array<double, 3>, 3> a{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< by row
  Point b{};

  Point operator()(Point x) const;
  /// A x, without b: where a direction goes.
  Point turn(Point x) const;
  /// This map after another one.
  AffineMap after(const AffineMap& first) const;

  double determinant() const;
  /// The largest factor by which the map stretches a vector: the largest singular value of A.
  double spectral_norm() const;
};

/// A turn about an axis through the origin, counterclockwise when it points to the viewer.
AffineMap turn_about(Point axis, double angle_rad);
/// The map with A multiplied by a number; b stays.
AffineMap scaled(const AffineMap& map, double factor);

}  // namespace silvafit::tree
