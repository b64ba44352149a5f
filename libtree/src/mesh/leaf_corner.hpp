// SPDX-License-Identifier: MIT
// Triangles of leaves oriented like their normals.
#pragma once

#include <cstdint>

#include "mesh/part_builder.hpp"
#include "mesh/sliver.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

struct LeafCorner {
  Point at{};
  Point normal{};
  std::uint32_t vertex = 0;  ///< of the part
};

/// A point as files have it.
inline Point stored(const Point& at) {
  return {static_cast<float>(at.x), static_cast<float>(at.y), static_cast<float>(at.z)};
}

/// Counterclockwise as seen from the side of the normals, so that viewers light the right side;
/// nothing if floats cannot distinguish the corners.
inline void add_leaf_triangle(const LeafCorner& a,
                              const LeafCorner& b,
                              const LeafCorner& c,
                              PartBuilder& build) {
  // The sides of a narrow face may change when its corners are rounded.
  const Point first = stored(a.at);
  const Point to_second = stored(b.at) - first;
  const Point to_third = stored(c.at) - first;
  const Point face = cross(to_second, to_third);
  if (is_sliver(to_second, to_third, face)) return;
  if (dot(face, a.normal + b.normal + c.normal) >= 0.0) {
    build.triangle(a.vertex, b.vertex, c.vertex);
  } else {
    build.triangle(a.vertex, c.vertex, b.vertex);
  }
}

}  // namespace silvafit::tree
