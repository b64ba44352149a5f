// SPDX-License-Identifier: MIT
// Triangles of leaves oriented like their normals.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesh/crown_light.hpp"
#include "mesh/part_builder.hpp"

namespace silvafit::tree {

/// Whether a triangle is so small or so narrow that floats cannot distinguish its sides.
/// \param face  cross product of its sides `ab` and `ac`
inline bool is_sliver(Point ab, Point ac, Point face) {
  constexpr double kSmallest = 1e-8;  // m2
  constexpr double kNarrowest = 2e-5;
  const double least = std::max(kSmallest, kNarrowest * (dot(ab, ab) + dot(ac, ac)));
  return dot(face, face) < least * least;
}

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

/// Points of one spray or tuft and the leaves between them.
///
/// Neighboring leaves share their points, which halves the size of a mesh.
class LeafSurface {
 public:
  LeafSurface(const Crown& crown, PartBuilder& build)
      : crown_(crown), build_(build), light_(crown) {}

  /// Starts a spray, with its maximum size.
  void begin(std::size_t points, std::size_t leaves, std::size_t fillings) {
    points_.clear();
    build_.reserve(points, 2 * leaves + fillings);
  }

  /// A point, moved into the crown if it is outside.
  /// \param lean  inclination of the surface relative to the crown's; much shorter than 1
  /// \returns its index in the spray
  std::size_t point(Point at, Point lean = {}) {
    const Point inside = crown_.confine(at);
    const Point normal = direction(light_.stretched(inside) + CrownLight::kAbove + lean);
    points_.push_back({inside, normal, build_.vertex(inside, normal)});
    return points_.size() - 1;
  }
  Point at(std::size_t number) const { return points_[number].at; }

  /// A leaf folded along its middle, counterclockwise from its base.
  void leaf(std::size_t base, std::size_t right, std::size_t tip, std::size_t left) {
    triangle(base, right, tip);
    triangle(base, tip, left);
  }
  void triangle(std::size_t a, std::size_t b, std::size_t c) {
    add_leaf_triangle(points_[a], points_[b], points_[c], build_);
  }

  /// Away from the inside of the crown, as on an ellipsoid with the crown's width and length.
  Point outward_of(Point at) const { return light_.outward(at); }

 private:
  const Crown& crown_;
  PartBuilder& build_;
  CrownLight light_;
  std::vector<LeafCorner> points_;
};

}  // namespace silvafit::tree
