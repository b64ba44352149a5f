// SPDX-License-Identifier: MIT
// The data of a skeleton that resolving overlaps needs.
#include <algorithm>
#include <cmath>

#include "silvafit/tree/overlap.hpp"

namespace silvafit::tree {
namespace {

/// Every fifth section is enough for the position of a stem.
std::vector<SkeletonPoint> thinned(std::span<const SkeletonPoint> line) {
  constexpr std::size_t kEach = 5;
  std::vector<SkeletonPoint> points;
  for (std::size_t i = 0; i + 1 < line.size(); i += kEach) points.push_back(line[i]);
  points.push_back(line.back());
  return points;
}

/// The axis that ends at the measured radius in one direction: within half a degree of it, as
/// measured in the field, and the longest; none if it is a centimeter too short.
std::optional<std::uint32_t> radius_axis(const Skeleton& skeleton, Point outward, double radius_m) {
  constexpr double kSector = 0.008726867790758789;  // tan(0.5 degrees)
  constexpr double kShort = 0.01;
  std::optional<std::uint32_t> found;
  double farthest = radius_m - kShort;
  for (std::uint32_t i = 0; i < skeleton.axes.size(); ++i) {
    if (skeleton.axes[i].order == 0) continue;
    const Point tip = skeleton.points_of(skeleton.axes[i]).back().at;
    const double along = tip.x * outward.x + tip.y * outward.y;
    const double across = std::abs(tip.x * outward.y - tip.y * outward.x);
    if (along > farthest && across <= kSector * along) {
      farthest = along;
      found = i;
    }
  }
  return found;
}

std::vector<SkeletonPoint> copy_of(std::span<const SkeletonPoint> line) {
  return {line.begin(), line.end()};
}

/// Axes whose children have children.
std::vector<bool> limbs_of(const Skeleton& skeleton) {
  std::vector<bool> is_limb(skeleton.axes.size(), false);
  for (const Axis& axis : skeleton.axes) {
    if (axis.order < 3) continue;
    is_limb[skeleton.axes[axis.parent].parent] = true;
  }
  return is_limb;
}

/// The branches at the measured radii, and all their parents.
std::vector<BranchLine> radius_branches_of(const Skeleton& skeleton, const CrownRadii& radii) {
  const std::array<std::pair<Point, double>, 4> directions{{{{1, 0, 0}, radii.east_m},
                                                            {{-1, 0, 0}, radii.west_m},
                                                            {{0, -1, 0}, radii.south_m},
                                                            {{0, 1, 0}, radii.north_m}}};
  std::vector<BranchLine> lines;
  for (const auto& [outward, radius] : directions) {
    const auto found = radius_axis(skeleton, outward, radius);
    if (!found) continue;
    for (std::uint32_t axis = *found; skeleton.axes[axis].order > 0;
         axis = skeleton.axes[axis].parent) {
      const auto listed = std::find_if(
          lines.begin(), lines.end(), [axis](const BranchLine& line) { return line.axis == axis; });
      const bool bears = axis != *found;
      if (listed != lines.end()) {
        listed->bears = listed->bears || bears;
      } else {
        lines.push_back({axis, copy_of(skeleton.points_of(skeleton.axes[axis])), bears});
      }
    }
  }
  return lines;
}

}  // namespace

StandTree stand_tree(const Morphology& morphology, const Crown& crown, const Skeleton& skeleton) {
  StandTree tree{.plot = morphology.plot,
                 .tree = morphology.tree,
                 .position = morphology.position,
                 .crown = std::make_shared<const Crown>(crown),
                 .stem = Lane(thinned(skeleton.points_of(skeleton.axes.front()))),
                 .radius_branches = radius_branches_of(skeleton, crown.radii())};
  const std::vector<bool> is_limb = limbs_of(skeleton);
  std::vector<bool> stays = is_limb;
  for (const BranchLine& line : tree.radius_branches) stays[line.axis] = true;
  for (std::uint32_t i = 0; i < skeleton.axes.size(); ++i) {
    const Axis& axis = skeleton.axes[i];
    const bool is_branch = axis.order == 1 || (axis.order > 1 && is_limb[axis.parent]);
    if (is_branch && !stays[i]) tree.branches.push_back({i, copy_of(skeleton.points_of(axis))});
  }
  return tree;
}

}  // namespace silvafit::tree
