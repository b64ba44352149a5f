// SPDX-License-Identifier: MIT
// Points and directions in a tree's own frame.
#pragma once

#include <cmath>

namespace silvafit::tree {

/// A point [m] or direction in a tree's own frame: x east, y north, z up, the origin where the
/// stem's axis meets the ground.
struct Point {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;

  friend Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Point operator*(double s, Point a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline double dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

inline Point cross(Point a, Point b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline double length(Point a) { return std::sqrt(dot(a, a)); }

/// The direction of `a`, or `otherwise` if `a` is too short.
inline Point direction(Point a, Point otherwise = {0.0, 0.0, 1.0}) {
  const double size = length(a);
  return size > 1e-12 ? (1.0 / size) * a : otherwise;
}

/// Directions along, across and above a line.
struct Frame {
  Point tangent{};
  Point sideways{};  ///< level
  Point upward{};
};

inline Frame frame_along(Point chord) {
  const Point tangent = direction(chord);
  const Point sideways = direction(cross({0.0, 0.0, 1.0}, tangent), {1.0, 0.0, 0.0});
  return {tangent, sideways, cross(tangent, sideways)};
}

}  // namespace silvafit::tree
