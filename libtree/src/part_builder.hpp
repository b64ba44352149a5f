// SPDX-License-Identifier: MIT
// Vertices and triangles as they are added to a part of a mesh.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

using Bytes4 = std::array<std::uint8_t, 4>;

/// Turns the tree's frame (z up) into the mesh's (y up) while it fills a part.
class PartBuilder {
 public:
  explicit PartBuilder(MeshPart& part) : part_(part) {}

  /// Makes room, so that a part's buffers do not move while it grows.
  void reserve(std::size_t vertices, std::size_t triangles, bool colored) {
    part_.positions.reserve(3 * vertices);
    part_.normals.reserve(3 * vertices);
    if (colored) part_.colors.reserve(4 * vertices);
    part_.indices.reserve(3 * triangles);
  }

  std::uint32_t vertex(Point at, Point normal) {
    const auto index = static_cast<std::uint32_t>(part_.vertex_count());
    push(part_.positions, at);
    push(part_.normals, normal);
    return index;
  }

  std::uint32_t vertex(Point at, Point normal, Bytes4 color) {
    part_.colors.insert(part_.colors.end(), color.begin(), color.end());
    return vertex(at, normal);
  }

  void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    part_.indices.insert(part_.indices.end(), {a, b, c});
  }

 private:
  static void push(std::vector<float>& to, Point p) {
    // Adding zero turns -0 into 0, so that equal places have equal bytes.
    const std::size_t size = to.size();
    to.resize(size + 3);
    to[size] = static_cast<float>(p.x) + 0.0F;
    to[size + 1] = static_cast<float>(p.z) + 0.0F;
    to[size + 2] = static_cast<float>(-p.y) + 0.0F;
  }

  MeshPart& part_;
};

/// Linear 0 .. 1 as a byte.
inline std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

}  // namespace silvafit::tree
