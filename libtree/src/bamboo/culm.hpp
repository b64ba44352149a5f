// SPDX-License-Identifier: MIT
// The culm of a bamboo: its nodes, and its line of Bezier curves.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bamboo/bamboo.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Q(t) = sum over k of B_k(t) V_k with the Bernstein polynomials B_k(t) = C(3, k) t^k (1-t)^(3-k).
/// Source: Liu et al. 2022, visual modeling of Phyllostachys pubescens, equation 1.
struct CubicBezier {
  std::array<Point, 4> control{};  ///< V_0 .. V_3

  /// The point at t in [0, 1].
  Point at(double t) const;
  /// dQ/dt.
  Point derivative(double t) const;
  /// The length of the curve between two parameters: Gauss-Legendre quadrature of |dQ/dt|, halved
  /// until twelve digits agree.
  double length_m(double from = 0.0, double to = 1.0) const;
};

/// An arch of a wanted length that starts in a wanted direction and turns by an angle.
///
/// The tangent at the end is the one at the base, turned by `bend_deg` towards `side` (V > 0) or
/// away from it (V < 0) in their common plane; the control points are those of the cubic that comes
/// nearest to an arc of a circle, 4/3 tan(bend/4) of its radius away from the ends. With a bend of
/// 0 or V = 0 it is a straight line.
/// \param along     direction at the base, of length 1
/// \param side      of length 1 and at a right angle to `along`
/// \param length_m  arc length D, >= 0
/// \param bend_deg  bend degree T: angle between the tangents at both ends, in [0, 180)
/// \param sense     V: only its sign is used
/// \throws UsageError if the length or the bend is out of range
CubicBezier bent_curve(
    Point base, Point along, Point side, double length_m, double bend_deg, double sense);

struct CulmNode {
  double z_m = 0.0;
  std::uint32_t number = 0;  ///< from the ground
};

/// A culm upright up to breast height and the crown base and bent above. Its tip nods.
class Culm {
 public:
  Culm(const TreeShape& shape, const Crown& crown, const CulmStyle& style, Random& random);

  /// The culm's center at a height.
  Point at(double z_m) const;
  /// Nodes from the ground up; unless the crown starts near the ground or the tip, one is at the
  /// crown base.
  const std::vector<CulmNode>& nodes() const { return nodes_; }
  const std::vector<Note>& notes() const { return notes_; }
  /// The side to which it leans and nods, from north over east.
  double lean_azimuth_rad() const { return lean_azimuth_deg_ * kRadian; }

  /// From the ground to the tip, with a ridge at each node; breast height is a point outside all
  /// ridges.
  std::vector<SkeletonPoint> points(const Taper& taper) const;

 private:
  void place_nodes(int internodes, Random& random);
  void bend(const TreeShape& shape, const Crown& crown, double bend_deg);
  Point bow(double z_m) const;

  const CulmStyle& style_;
  double h_m_;
  double hcb_m_;
  double dbh_cm_;
  std::vector<CulmNode> nodes_{};
  double lean_azimuth_deg_ = 0.0;
  double bent_from_m_ = 0.0;  ///< the height of the tip if the culm is straight
  CubicBezier curve_{};       ///< above that
  double bow_m_ = 0.0;        ///< the largest distance from that curve, below the nodding tip
  std::vector<Note> notes_{};
};

}  // namespace silvafit::tree
