// SPDX-License-Identifier: MIT
// Cubic Bezier curves: fitted to measured points, and bent by a given angle.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Q(t) = sum over k of B_k(t) V_k with the Bernstein polynomials B_k(t) = C(3, k) t^k (1-t)^(3-k).
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

/// B_0 .. B_3 at t.
std::array<double, 4> bernstein(double t);

/// The relative polyline length at each point: 0 for the first, 1 for the last.
/// \throws GeometryError if all points are equal
std::vector<double> chord_length_parameters(std::span<const Point> points);

/// The cubic with V_0 = p_0 and V_3 = p_n whose sum of squared distances |Q(t_i) - p_i|^2 at the
/// inner points is least:
///   V_1 = (A_2 C_1 - A_12 C_2) / (A_1 A_2 - A_12^2)
///   V_2 = (A_1 C_2 - A_12 C_1) / (A_1 A_2 - A_12^2)
/// where A_k = sum B_k^2, A_12 = sum B_1 B_2, C_k = sum B_k (p_i - B_0 V_0 - B_3 V_3), all over the
/// inner points.
///
/// \param points      p_0 .. p_n, along the curve
/// \param parameters  t_0 .. t_n, one a point, from 0 to 1 in order
/// \throws UsageError if there are not as many parameters as points, or they are not such numbers;
/// GeometryError if there are fewer than two inner points, or they do not determine the curve: all
/// at one parameter, or at the ends
/// Source: Liu et al. 2022, visual modeling of Phyllostachys pubescens, equations 1 to 4.
CubicBezier fit_bezier(std::span<const Point> points, std::span<const double> parameters);

/// The same with chord-length parameters.
CubicBezier fit_bezier(std::span<const Point> points);

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

}  // namespace silvafit::tree
