// SPDX-License-Identifier: MIT
#include "tube.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "part_builder.hpp"

namespace silvafit::tree {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Directions of a regular polygon's corners in the plane (x, y).
std::vector<Point> corners(int sides) {
  std::vector<Point> result;
  for (int i = 0; i < sides; ++i) {
    const double angle = kTwoPi * i / sides;
    result.push_back({std::cos(angle), std::sin(angle), 0.0});
  }
  return result;
}

/// Marks the points between `first` and `last` without which the radius, linear between the marked
/// ones, would be off by more than the tolerance (Douglas and Peucker 1973).
void mark_needed(std::span<const SkeletonPoint> axis,
                 std::size_t first,
                 std::size_t last,
                 double tolerance,
                 std::vector<bool>& needed) {
  const SkeletonPoint& a = axis[first];
  const SkeletonPoint& b = axis[last];
  double worst = tolerance;
  std::size_t at = first;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double part = (axis[i].at.z - a.at.z) / (b.at.z - a.at.z);
    const double error =
        std::abs(axis[i].radius_m - (a.radius_m + part * (b.radius_m - a.radius_m)));
    if (error > worst || tolerance == 0.0) {
      worst = error;
      at = i;
      if (tolerance == 0.0) break;
    }
  }
  if (at == first) return;
  needed[at] = true;
  mark_needed(axis, first, at, tolerance, needed);
  mark_needed(axis, at, last, tolerance, needed);
}

std::vector<SkeletonPoint> needed_sections(std::span<const SkeletonPoint> axis, double tolerance) {
  constexpr double kBreastHeight = 1.3;
  std::vector<bool> needed(axis.size(), false);
  std::size_t from = 0;
  needed.front() = needed.back() = true;
  for (std::size_t i = 1; i + 1 < axis.size(); ++i) {
    if (axis[i].at.z != kBreastHeight) continue;
    needed[i] = true;
    mark_needed(axis, 0, i, tolerance, needed);
    from = i;
  }
  mark_needed(axis, from, axis.size() - 1, tolerance, needed);
  std::vector<SkeletonPoint> sections;
  for (std::size_t i = 0; i < axis.size(); ++i) {
    if (needed[i]) sections.push_back(axis[i]);
  }
  return sections;
}

/// Joins a ring with the one before it; both have `sides` vertices one after the other.
void join_rings(PartBuilder& build, std::uint32_t lower, std::uint32_t upper, std::uint32_t sides) {
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t j = (i + 1) % sides;
    build.triangle(lower + i, lower + j, upper + j);
    build.triangle(lower + i, upper + j, upper + i);
  }
}

void close_with_tip(PartBuilder& build,
                    std::uint32_t ring,
                    std::uint32_t tip,
                    std::uint32_t sides) {
  for (std::uint32_t i = 0; i < sides; ++i) build.triangle(ring + i, ring + (i + 1) % sides, tip);
}

}  // namespace

void add_stem(std::span<const SkeletonPoint> axis, const MeshOptions& options, MeshPart& part) {
  PartBuilder build(part);
  const std::vector<Point> polygon = corners(options.stem_sides);
  const auto sides = static_cast<std::uint32_t>(options.stem_sides);
  // The regular polygon with the area of the circle has corners a little outside it.
  const double enlarged = std::sqrt(kTwoPi / (sides * std::sin(kTwoPi / sides)));
  const std::vector<SkeletonPoint> sections = needed_sections(axis, options.stem_tolerance_m);
  std::uint32_t ring = 0;
  for (std::size_t i = 0; i + 1 < sections.size(); ++i) {
    const SkeletonPoint& here = sections[i];
    const SkeletonPoint& next = sections[i + 1];
    const double slope = (here.radius_m - next.radius_m) / (next.at.z - here.at.z);
    const auto first = static_cast<std::uint32_t>(part.vertex_count());
    for (const Point& corner : polygon) {
      build.vertex(here.at + enlarged * here.radius_m * corner,
                   direction({corner.x, corner.y, slope}));
    }
    if (i > 0) join_rings(build, ring, first, sides);
    ring = first;
  }
  const std::uint32_t tip = build.vertex(sections.back().at, {0.0, 0.0, 1.0});
  close_with_tip(build, ring, tip, sides);

  const SkeletonPoint& foot = sections.front();
  const Point down = {0.0, 0.0, -1.0};
  const std::uint32_t center = build.vertex(foot.at, down);
  for (const Point& corner : polygon) {
    build.vertex(foot.at + enlarged * foot.radius_m * corner, down);
  }
  for (std::uint32_t i = 0; i < sides; ++i) {
    build.triangle(center, center + 1 + (i + 1) % sides, center + 1 + i);
  }
}

void add_branch(std::span<const SkeletonPoint> axis,
                int sides,
                const Crown& crown,
                MeshPart& part) {
  PartBuilder build(part);
  const auto count = static_cast<std::uint32_t>(sides);
  // Branches bow so little that one frame serves along the whole of one.
  const Point tangent = direction(axis.back().at - axis.front().at);
  const Point sideways = direction(cross({0.0, 0.0, 1.0}, tangent), {1.0, 0.0, 0.0});
  const Point upward = cross(tangent, sideways);
  const std::vector<Point> polygon = corners(sides);
  std::uint32_t ring = 0;
  for (std::size_t i = 0; i + 1 < axis.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(part.vertex_count());
    for (const Point& corner : polygon) {
      const Point normal = corner.x * sideways + corner.y * upward;
      build.vertex(crown.confine(axis[i].at + axis[i].radius_m * normal), normal);
    }
    if (i > 0) join_rings(build, ring, first, count);
    ring = first;
  }
  close_with_tip(build, ring, build.vertex(axis.back().at, tangent), count);
}

}  // namespace silvafit::tree
