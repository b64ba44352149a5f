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

/// Counterclockwise as seen from the side of the normals, so that viewers light the right side;
/// nothing if floats cannot distinguish the corners.
inline void add_leaf_triangle(const LeafCorner& a,
                              const LeafCorner& b,
                              const LeafCorner& c,
                              PartBuilder& build) {
  const Point face = cross(b.at - a.at, c.at - a.at);
  if (is_sliver(b.at - a.at, c.at - a.at, face)) return;
  if (dot(face, a.normal + b.normal + c.normal) >= 0.0) {
    build.triangle(a.vertex, b.vertex, c.vertex);
  } else {
    build.triangle(a.vertex, c.vertex, b.vertex);
  }
}

}  // namespace silvafit::tree
