// SPDX-License-Identifier: MIT
#include "segments/skeleton_line.hpp"

#include <algorithm>
#include <limits>

#include "silvafit/base/error.hpp"

namespace silvafit::tree {

void check_finite(const Skeleton& skeleton) {
  const auto zero = [](Point p) { return 0.0 * p.x + 0.0 * p.y + 0.0 * p.z; };
  double sum = 0.0;
  for (const SkeletonPoint& point : skeleton.points) sum += zero(point.at) + 0.0 * point.radius_m;
  for (const LeafSite& leaf : skeleton.leaves) {
    sum += zero(leaf.at) + zero(leaf.along) + zero(leaf.facing) + 0.0 * leaf.length_m;
  }
  if (sum != 0.0) throw GeometryError("the skeleton has a coordinate that is not finite");
}

double line_length_m(std::span<const SkeletonPoint> line) {
  double sum = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += length(line[i].at - line[i - 1].at);
  return sum;
}

SkeletonPoint point_at(std::span<const SkeletonPoint> line, double share) {
  double left = share * line_length_m(line);
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double size = length(line[i].at - line[i - 1].at);
    if (left <= size && size > 0.0) return between(line[i - 1], line[i], left / size);
    left -= size;
  }
  return line.back();
}

SkeletonPoint at_height(std::span<const SkeletonPoint> line, double z) {
  const auto above =
      std::lower_bound(line.begin(), line.end(), z, [](const SkeletonPoint& point, double height) {
        return point.at.z < height;
      });
  if (above == line.begin()) return line.front();
  if (above == line.end()) return line.back();
  const SkeletonPoint& a = *(above - 1);
  return between(a, *above, (z - a.at.z) / (above->at.z - a.at.z));
}

PlaceOnLine nearest_place(std::span<const SkeletonPoint> line, Point point) {
  PlaceOnLine best;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Point along = line[i + 1].at - line[i].at;
    const Point away = point - line[i].at;
    const double squared = dot(along, along);
    const double part = squared > 0.0 ? std::clamp(dot(away, along) / squared, 0.0, 1.0) : 0.0;
    const Point gap = away - part * along;
    if (dot(gap, gap) < nearest) {
      nearest = dot(gap, gap);
      best = {i, part};
    }
  }
  return best;
}

double nearest_share(std::span<const SkeletonPoint> line, Point point) {
  const auto [segment, part] = nearest_place(line, point);
  const double before = line_length_m(line.first(segment + 1));
  return (before + part * length(line[segment + 1].at - line[segment].at)) / line_length_m(line);
}

bool is_same_line(std::span<const SkeletonPoint> a, std::span<const SkeletonPoint> b) {
  return std::equal(
      a.begin(), a.end(), b.begin(), b.end(), [](const SkeletonPoint& p, const SkeletonPoint& q) {
        return p.at.x == q.at.x && p.at.y == q.at.y && p.at.z == q.at.z;
      });
}

}  // namespace silvafit::tree
