// SPDX-License-Identifier: MIT
#include "fitted/standing_skeleton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "segments/skeleton_line.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::tree {
namespace {

/// The axes that form the stem: the stem itself, then at each end the branch that continues there
/// and rises highest.
std::vector<std::uint32_t> leaders(const Skeleton& grown) {
  std::vector<std::uint32_t> chain{0};
  constexpr double kAtTip = 0.02;
  while (chain.size() + 1 < grown.axes.size()) {
    const auto line = grown.points_of(grown.axes[chain.back()]);
    const Point tip = line.back().at;
    const double near = kAtTip * line_length_m(line);
    std::uint32_t next = kNone;
    double highest = tip.z;
    for (std::uint32_t i = chain.back() + 1; i < grown.axes.size(); ++i) {
      if (grown.axes[i].parent != chain.back()) continue;
      const auto child = grown.points_of(grown.axes[i]);
      if (length(child.front().at - tip) > near || child.back().at.z <= highest) continue;
      highest = child.back().at.z;
      next = i;
    }
    if (next == kNone) break;
    chain.push_back(next);
  }
  return chain;
}

/// The skeleton whose stem is the whole chain.
Skeleton with_stem(const Skeleton& grown, const std::vector<std::uint32_t>& chain) {
  Skeleton result;
  result.notes = grown.notes;
  result.points.reserve(grown.points.size());
  result.axes.reserve(grown.axes.size());
  std::vector<std::uint32_t> number(grown.axes.size(), kNone);
  for (const std::uint32_t axis : chain) {
    number[axis] = 0;
    auto line = grown.points_of(grown.axes[axis]);
    if (axis != 0) line = line.subspan(1);
    result.points.insert(result.points.end(), line.begin(), line.end());
  }
  result.axes.push_back({.count = static_cast<std::uint32_t>(result.points.size())});
  for (std::uint32_t i = 1; i < grown.axes.size(); ++i) {
    if (number[i] == 0) continue;
    const Axis& axis = grown.axes[i];
    const std::uint32_t parent = number[axis.parent];
    number[i] = result.add_axis(result.axes[parent].order + 1, parent, grown.points_of(axis));
  }
  result.leaves = grown.leaves;
  for (LeafSite& leaf : result.leaves) leaf.axis = number[leaf.axis];
  return result;
}

/// Moves the stem's base to the origin and turns the line from its base to its tip upright.
void set_upright(Skeleton& skeleton) {
  const auto stem = skeleton.points_of(skeleton.axes.front());
  const Point base = stem.front().at;
  const Point chord = stem.back().at - base;
  if (!(chord.z > 0.0)) throw GeometryError("the stem of the skeleton does not rise");
  const Point from = direction(chord);
  const Point up{0.0, 0.0, 1.0};
  for (SkeletonPoint& point : skeleton.points) point.at = turned_with(point.at - base, from, up);
  for (LeafSite& leaf : skeleton.leaves) {
    leaf.at = turned_with(leaf.at - base, from, up);
    leaf.along = turned_with(leaf.along, from, up);
    leaf.facing = turned_with(leaf.facing, from, up);
  }
}

/// The stem's points that are higher than all previous ones.
std::vector<SkeletonPoint> rising_course(std::span<const SkeletonPoint> stem) {
  std::vector<SkeletonPoint> course{stem.front()};
  for (const SkeletonPoint& point : stem.subspan(1)) {
    if (point.at.z > course.back().at.z) course.push_back(point);
  }
  return course;
}

}  // namespace

Point turned_with(Point v, Point from, Point to) {
  // Rodrigues' formula with the axis from x to, whose length is the sine of the angle.
  const Point axis = cross(from, to);
  const double cosine = dot(from, to);
  constexpr double kOpposite = 1e-9;
  if (1.0 + cosine < kOpposite) return -1.0 * v;
  return cosine * v + cross(axis, v) + (dot(axis, v) / (1.0 + cosine)) * axis;
}

void check_grown(const Skeleton& grown) {
  if (grown.axes.empty() || grown.axes.front().order != 0 || grown.axes.front().count < 2) {
    throw GeometryError("the skeleton has no stem");
  }
  if (grown.axes.size() < 2) throw GeometryError("the skeleton has no branch");
  check_finite(grown);
  for (const LeafSite& leaf : grown.leaves) {
    if (leaf.axis >= grown.axes.size()) {
      throw GeometryError("the skeleton has a leaf without an axis");
    }
  }
}

StandingSkeleton standing(const Skeleton& grown) {
  check_grown(grown);
  StandingSkeleton result;
  result.skeleton = with_stem(grown, leaders(grown));
  Skeleton& skeleton = result.skeleton;
  set_upright(skeleton);
  result.course = rising_course(skeleton.points_of(skeleton.axes.front()));

  const auto straighten = [&](Point& at) {
    const Point stem = at_height(result.course, at.z).at;
    at.x -= stem.x;
    at.y -= stem.y;
  };
  const std::size_t of_stem = skeleton.axes.front().count;
  result.top = result.course.back().at.z;
  result.lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < skeleton.points.size(); ++i) {
    Point& at = skeleton.points[i].at;
    straighten(at);
    if (i < of_stem) continue;
    result.top = std::max(result.top, at.z);
    result.lowest = std::min(result.lowest, at.z);
  }
  for (LeafSite& leaf : skeleton.leaves) straighten(leaf.at);
  result.first_base = result.top;
  for (const Axis& axis : skeleton.axes) {
    if (axis.order != 1) continue;
    result.first_base = std::min(result.first_base, skeleton.points[axis.first].at.z);
  }
  return result;
}

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
    // The thinnest axes of a figure are seen in a picture of the whole tree. Their tips are points.
    constexpr double kThinnest = 0.001;
    if (point.radius_m > 0.0 && point.at.z > kBreastHeight) {
      point.radius_m = std::max(point.radius_m, kThinnest * h_m);
    }
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
