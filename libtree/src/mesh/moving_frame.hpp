// SPDX-License-Identifier: MIT
// Frames that go along a curve without turning about it.
#pragma once

#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// A direction at a right angle to `tangent` that is as near as can be to `wanted`, of length 1.
inline Point square_to(Point tangent, Point wanted) {
  const Point flat = wanted - dot(wanted, tangent) * tangent;
  // Any other direction will do where the wanted one runs along.
  const Point other = std::abs(tangent.x) < 0.7 ? Point{1.0, 0.0, 0.0} : Point{0.0, 1.0, 0.0};
  return length(flat) > 1e-6 ? direction(flat) : direction(other - dot(other, tangent) * tangent);
}

/// The direction `sideways` at one point of a curve, brought to a next one without turning about
/// the curve. Both tangents have length 1.
///
/// Source: Wang, Juettler, Zheng and Liu 2008, Computation of rotation minimizing frames, ACM
/// Transactions on Graphics 27(1), the double reflection: in the plane halfway between the points,
/// then in the one that brings the tangent into its place. The error falls with the fourth power of
/// the step.
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
