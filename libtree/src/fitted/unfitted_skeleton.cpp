// SPDX-License-Identifier: MIT
#include "fitted/unfitted_skeleton.hpp"

#include <algorithm>
#include <cmath>

#include "fitted/standing_skeleton.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {

Skeleton scaled_to_height(Skeleton grown, double h_m) {
  check_grown(grown);
  const Point base = grown.points_of(grown.axes.front()).front().at;
  double top = 0.0;
  for (const SkeletonPoint& point : grown.points) top = std::max(top, point.at.z - base.z);
  if (!(top > 0.0)) throw GeometryError("the skeleton does not rise above its base");
  const double scale = h_m / top;
  for (SkeletonPoint& point : grown.points) {
    point.at = scale * (point.at - base);
    point.radius_m *= scale;
  }
  for (LeafSite& leaf : grown.leaves) {
    leaf.at = scale * (leaf.at - base);
    leaf.length_m *= scale;
  }
  return grown;
}

TreeShape shape_of(const Skeleton& skeleton) {
  // A crown without width or length has no inside and no shade.
  constexpr double kLeast = 0.01;
  TreeShape shape{.radii = {kLeast, kLeast, kLeast, kLeast}};
  for (const SkeletonPoint& point : skeleton.points) shape.h_m = std::max(shape.h_m, point.at.z);
  shape.hcb_m = shape.hc_m = shape.h_m - kLeast;
  double widest = 0.0;
  for (const Axis& axis : skeleton.axes) {
    if (axis.order == 0) continue;
    for (const auto& [at, radius_m] : skeleton.points_of(axis)) {
      shape.hcb_m = std::min(shape.hcb_m, std::max(at.z, 0.0));
      shape.radii.east_m = std::max(shape.radii.east_m, at.x);
      shape.radii.west_m = std::max(shape.radii.west_m, -at.x);
      shape.radii.north_m = std::max(shape.radii.north_m, at.y);
      shape.radii.south_m = std::max(shape.radii.south_m, -at.y);
      const double away = std::hypot(at.x, at.y);
      if (away <= widest) continue;
      widest = away;
      shape.hc_m = at.z;
    }
  }
  shape.hc_m = std::clamp(shape.hc_m, shape.hcb_m, shape.h_m);
  // Leaves have depth on a flat drawing too.
  constexpr double kDepth = 0.1;
  CrownRadii& r = shape.radii;
  const double least = kDepth * r.widest_m();
  for (double* radius : {&r.east_m, &r.west_m, &r.south_m, &r.north_m}) {
    *radius = std::max(*radius, least);
  }
  return shape;
}

}  // namespace silvafit::tree
