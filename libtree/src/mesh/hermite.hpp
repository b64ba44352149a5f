// SPDX-License-Identifier: MIT
// Cubic curves through the points of an axis.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// A point that a curve passes through.
struct HermiteKnot {
  Point at{};
  double radius_m = 0.0;
  double parameter = 0.0;
  Point rate{};  ///< derivative of the position by the parameter
};

/// Sets the parameters of knots with known positions, of which consecutive ones differ: each step
/// is the square root of the distance. A curve with these parameters has no cusps, and no piece
/// intersects itself (Yuksel, Schaefer and Keyser 2011, Computer-Aided Design 43(7), 747-755).
void set_centripetal_parameters(std::span<HermiteKnot> knots);

/// Sets the derivatives of all knots: at inner ones those of the parabola through each and its
/// neighbors, at the last one those of a natural end. The curve is C1.
/// \param start  direction in which it leaves the first knot, of length 1
void set_rates(std::span<HermiteKnot> knots, Point start);

/// The curve between two knots, by the relative parameter in [0, 1].
class HermitePiece {
 public:
  HermitePiece() = default;
  HermitePiece(const HermiteKnot& from, const HermiteKnot& to);

  Point at(double share) const { return a_ + share * (b_ + share * (c_ + share * d_)); }
  /// Derivative by the relative parameter.
  Point rate(double share) const { return b_ + share * (2.0 * c_ + (3.0 * share) * d_); }
  /// By the relative length instead of the parameter.
  double radius_m(double length_share) const {
    return radius_[0] +
           length_share * (radius_[1] + length_share * (radius_[2] + length_share * radius_[3]));
  }
  /// The cubic with these radii at its ends, and these slopes by the curve's length.
  void set_radius(double from_m, double from_slope, double to_m, double to_slope);

  /// Length of the curve up to there [m], by Gauss and Legendre's rule of five points.
  double length_m(double share) const;
  double length_m() const { return length_m_; }
  /// The parameter at which the curve has this length, in [0, length_m()].
  double share_at(double length_m) const;

  /// The number of straight steps of equal length that approximate a curve, its tube's radius and
  /// its tube's corners within the tolerance.
  double steps_within(double tolerance_m) const;

 private:
  Point a_{};
  Point b_{};
  Point c_{};
  Point d_{};
  std::array<double, 4> radius_{};
  double length_m_ = 0.0;
};

/// Sets the radii along pieces so that the radius between two knots is between theirs, and
/// straight cones stay straight (Fritsch and Carlson 1980, SIAM Journal on Numerical Analysis
/// 17(2), 238-246).
void set_monotone_radii(std::span<const HermiteKnot> knots, std::span<HermitePiece> pieces);

}  // namespace silvafit::tree
