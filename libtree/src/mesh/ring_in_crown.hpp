// SPDX-License-Identifier: MIT
// Rings of wood that stay inside the crown.
#pragma once

#include <span>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

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
