// SPDX-License-Identifier: MIT
// Frames that follow a curve without twisting about it.
#pragma once

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// The direction orthogonal to `tangent` that is closest to `wanted`, of length 1.
inline Point square_to(Point tangent, Point wanted) {
  const Point flat = wanted - dot(wanted, tangent) * tangent;
  // If `wanted` is parallel to the tangent, any other direction is used.
  const Point other = std::abs(tangent.x) < 0.7 ? Point{1.0, 0.0, 0.0} : Point{0.0, 1.0, 0.0};
  return length(flat) > 1e-6 ? direction(flat) : direction(other - dot(other, tangent) * tangent);
}

/// The direction `sideways` at one point of a curve, moved to the next one without twist about
/// the curve. Both tangents have length 1.
///
/// Source: Wang, Juettler, Zheng and Liu 2008, Computation of rotation minimizing frames, ACM
/// Transactions on Graphics 27(1), the double reflection: in the plane halfway between the points,
/// then in the plane that maps the tangent to the next one. The error decreases with the fourth
/// power of the step.
inline Point carried_on(
    Point from, Point from_tangent, Point sideways, Point to, Point to_tangent) {
  const auto reflected = [](Point what, Point normal) {
    const double squared = dot(normal, normal);
    return squared > 1e-24 ? what - (2.0 * dot(normal, what) / squared) * normal : what;
  };
  const Point step = to - from;
  const Point turned = to_tangent - reflected(from_tangent, step);
  return square_to(to_tangent, reflected(reflected(sideways, step), turned));
}

}  // namespace silvafit::tree
