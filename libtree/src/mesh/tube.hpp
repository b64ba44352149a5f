// SPDX-License-Identifier: MIT
// Rings around an axis, the tube between them, and rings that stay inside a crown.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "mesh/bark_surface.hpp"
#include "mesh/part_builder.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// A section of a tube, orthogonal to `tangent`. `sideways` and `upward` are orthogonal to it and
/// to each other; all three have length 1.
struct Ring {
  Point at{};
  double radius_m = 0.0;
  Point tangent{};
  Point sideways{};
  Point upward{};
  double along_m = 0.0;   ///< length of the curve up to here
  bool is_fixed = false;  ///< drawn for any tolerance

  /// A direction of the plane (x, y) in the plane of the ring.
  Point across(Point flat) const { return flat.x * sideways + flat.y * upward; }
  /// Rotates the ring orthogonal to a direction, keeping its own sideways as far as possible.
  void turn(Point along, Point aside);
};

/// Distance of a ring from the straight tube between two others.
struct RingOffset {
  Point middle{};
  Point sideways{};  ///< of the end of the sideways radius, in addition to the center's
  Point upward{};
};

/// At the ring's relative position between `a` and `b`, or at the nearer one if outside.
RingOffset offset_between(const Ring& a, const Ring& b, const Ring& ring);

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

/// Corners of the regular polygon with the area of the unit circle.
std::vector<Point> equal_area_corners(int sides);

/// The sections of a stem with those that its roots need; the stem between them stays as it is.
std::vector<Ring> with_root_sections(std::span<const Ring> sections, const RootFlare& roots);

struct TubeLook {
  bool textured = false;       ///< with a seam, UVs and tangents for textures
  bool is_open = false;        ///< at its base, which is inside its parent
  bool has_foot = false;       ///< its base is visible, and has normals of its own
  double bark_radius_m = 0.0;  ///< of the wood whose bark it has; 0: the thicker of the first rings
  std::optional<RootFlare> roots{};
};

/// Adds a tube that ends in a point.
/// \param corners  of its sections, for radius 1
void add_tube(std::span<const Ring> rings,
              std::span<const Point> corners,
              const TubeLook& look,
              PartBuilder& build);

/// Sections of wood with one shape and direction, at any position and of any thickness.
class RingInCrown {
 public:
  /// \param corners           of the section in its plane, for a radius of 1; they outlive this
  /// \param sideways, upward  the plane in space
  RingInCrown(const Crown& crown, std::span<const Point> corners, Point sideways, Point upward)
      : crown_(crown), corners_(corners), sideways_(sideways), upward_(upward) {}

  bool contains(Point at, double radius_m) const;

  /// Lifts a ring that would reach out of the crown to the crown base, then makes it smaller until
  /// it fits, and moves it towards the stem if this is not enough.
  /// \param let_pass_m  a radius that may be outside, so that no ring becomes a point
  /// \returns whether it fits
  bool fit(Point& at, double& radius_m, double let_pass_m) const;

 private:
  Point across(Point corner) const { return corner.x * sideways_ + corner.y * upward_; }
  double lowest() const;
  bool move_inward(Point& at, double radius_m, double step_m) const;

  const Crown& crown_;
  std::span<const Point> corners_;
  Point sideways_;
  Point upward_;
};

}  // namespace silvafit::tree
