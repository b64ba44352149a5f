// SPDX-License-Identifier: MIT
// Positions on a line of skeleton points: by length, by height, nearest to a point.
#pragma once

#include <cstddef>
#include <span>

#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// \throws GeometryError if a coordinate is not finite
void check_finite(const Skeleton& skeleton);

/// Length of a line of points [m].
double line_length_m(std::span<const SkeletonPoint> line);

/// The point at a relative length of a line.
SkeletonPoint point_at(std::span<const SkeletonPoint> line, double share);

/// The position and radius of a rising line of points at a height.
SkeletonPoint at_height(std::span<const SkeletonPoint> line, double z);

/// A position on a line of points.
struct PlaceOnLine {
  std::size_t segment = 0;  ///< from points[segment] to points[segment + 1]
  double part = 0.0;        ///< of the segment, 0 .. 1
};

/// The position on a line that is nearest to a point; of several, the first.
PlaceOnLine nearest_place(std::span<const SkeletonPoint> line, Point point);

/// The same as relative length of the line.
double nearest_share(std::span<const SkeletonPoint> line, Point point);

/// Whether two lines have the same points, for any radii.
bool is_same_line(std::span<const SkeletonPoint> a, std::span<const SkeletonPoint> b);

/// Points along a line at most this far apart [m] represent the line.
inline constexpr double kLineStep = 0.025;

/// Calls visit(fraction, point) at equal steps of at most kLineStep along a line, from its start to
/// its end, until it returns false.
template <typename Visit>
void walk(std::span<const SkeletonPoint> line, Visit visit) {
  const double total = line_length_m(line);
  const auto steps = static_cast<int>(total / kLineStep) + 4;
  const double step = total / steps;
  double before = 0.0;  // length up to the segment
  std::size_t to = 1;
  double size = length(line[1].at - line[0].at);
  for (int i = 0; i <= steps; ++i) {
    const double at = i * step;
    while (to + 1 < line.size() && at > before + size) {
      before += size;
      ++to;
      size = length(line[to].at - line[to - 1].at);
    }
    // The last point is exactly the line's own end.
    const bool is_end = i == steps;
    const double part = is_end ? 1.0 : (size > 0.0 ? (at - before) / size : 0.0);
    const SkeletonPoint point = is_end ? line.back() : between(line[to - 1], line[to], part);
    if (!visit(static_cast<double>(i) / steps, point)) return;
  }
}

}  // namespace silvafit::tree
