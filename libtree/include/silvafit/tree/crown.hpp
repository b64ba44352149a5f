// SPDX-License-Identifier: MIT
// The crown curve: the surface that encloses the crown of a tree.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Curvature of the crown above and below its widest height; 1 is a cone, 2 a paraboloid.
struct CrownIndex {
  double up = 2.0;
  double down = 2.0;
};

/// The crown between the curves
///   up(x)   = H - (H - Hc) (x / Cr)^a_up,   x in [0, Cr]
///   down(x) = Hb + (Hc - Hb) (x / Cr)^a_down
/// where x is the distance from the stem's axis and Cr the crown radius in that azimuth. Between
/// the four measured directions Cr = Cr_x cos^2 + Cr_y sin^2 of the angle to the east-west axis:
/// smooth, never outside the two radii that it lies between. For 1 <= a <= 2 every vertical section
/// through the axis is convex.
///
/// Source: the crown curve of the Chinese fir segment models; see docs/trees.md.
class Crown {
 public:
  /// Directions of the four measured radii: east, west, south, north.
  static constexpr std::array<Point, 4> kMeasured{{{1, 0, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 1, 0}}};

  /// \throws DomainError if an index is outside [1, 2]
  Crown(const TreeShape& shape, CrownIndex index);

  /// A crown with these measurements that contains every point, for trees that are drawn as they
  /// are.
  static Crown unbounded(const TreeShape& shape);

  bool is_bounded() const { return is_bounded_; }
  double h_m() const { return h_m_; }
  double hcb_m() const { return hcb_m_; }
  double hc_m() const { return hc_m_; }
  const CrownRadii& radii() const { return radii_; }

  /// Crown radius in the direction (x east, y north), which need not have length 1 [m].
  double radius_m(double x, double y) const;
  /// The crown's widest point in a measured direction.
  Point widest_point(std::size_t direction) const;

  /// Height of the upper curve at a distance from the axis, where the crown has radius `radius_m`.
  double up_m(double distance_m, double radius_m) const;
  /// Height of the lower curve.
  double down_m(double distance_m, double radius_m) const;
  /// Width of the crown at a height relative to its widest; 0 outside [hcb, h].
  double relative_width(double z_m) const;

  /// Distance from the axis at which a ray from the axis leaves the crown: the solution x of
  /// base + x / tan(angle) = up(x) or down(x).
  /// \param base_m     height of the ray's start on the axis, in [hcb, h]
  /// \param angle_rad  angle between the ray and the upward vertical, in (0, pi/2]
  /// \param radius_m   crown radius in the ray's azimuth
  double matching_distance_m(double base_m, double angle_rad, double radius_m) const;

  /// Distance of a point outside the crown [m], vertical or horizontal, whichever is shorter; 0
  /// inside. Never less than the distance to the crown in the point's own azimuth.
  double excess_m(Point point) const;

  bool contains(Point point) const;

  /// Distance from a point inside to the crown surface along a direction, at most `wanted`; found
  /// to a sixty-fourth of that, on the inner side.
  /// \param along  of length 1
  double length_inside_m(Point from, Point along, double wanted_m) const;

  /// The point itself if it is inside, else the point moved vertically into [hcb, h] and then
  /// horizontally towards the axis until it is inside.
  Point confine(Point point) const;

 private:
  double tabulated_width(double z_m) const;
  /// The crown's radius in the point's azimuth times its squared distance from the axis.
  double weighted_radii(Point point, double xx, double yy) const;

  double h_m_;
  double hcb_m_;
  double hc_m_;
  CrownRadii radii_;
  CrownIndex index_;
  bool is_bounded_ = true;
  double per_up_m_ = 0.0;
  double per_down_m_ = 0.0;
  std::vector<double> widths_up_;    ///< relative width at equal steps from h down to hc
  std::vector<double> widths_down_;  ///< and from hcb up to hc
};

}  // namespace silvafit::tree
