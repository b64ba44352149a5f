// SPDX-License-Identifier: MIT
#include "fitted_leaves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "standing_skeleton.hpp"

namespace silvafit::tree {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

/// Sum of the lengths of all branches in the grown and in the fitted skeleton.
double mean_scale(const Skeleton& grown,
                  const Skeleton& fitted,
                  const std::vector<std::uint32_t>& number) {
  const auto length_of = [](std::span<const SkeletonPoint> line) {
    double sum = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) sum += length(line[i].at - line[i - 1].at);
    return sum;
  };
  double before = 0.0;
  double after = 0.0;
  for (std::size_t i = 1; i < grown.axes.size(); ++i) {
    before += length_of(grown.points_of(grown.axes[i]));
    if (number[i] != kNone) after += length_of(fitted.points_of(fitted.axes[number[i]]));
  }
  return before > 0.0 ? after / before : 1.0;
}

/// Moves and turns a leaf as the nearest piece of its axis was.
void move_with_axis(LeafSite& leaf,
                    std::span<const SkeletonPoint> from,
                    std::span<const SkeletonPoint> to,
                    double scale) {
  const PlaceOnLine place = nearest_place(from, leaf.at);
  const Point grown_along = from[place.segment + 1].at - from[place.segment].at;
  const Point along = to[place.segment + 1].at - to[place.segment].at;
  const Point before = direction(grown_along);
  const Point now = direction(along, before);
  const Point away = leaf.at - (from[place.segment].at + place.part * grown_along);
  leaf.at = to[place.segment].at + place.part * along + scale * turned_with(away, before, now);
  leaf.along = direction(turned_with(leaf.along, before, now));
  leaf.facing = turned_with(leaf.facing, before, now);
  leaf.facing = direction(leaf.facing - dot(leaf.facing, leaf.along) * leaf.along);
}

/// Moves a leaf whose tip is outside in, and shortens it where that is not enough.
/// \return whether anything is left of it
bool bring_inside(LeafSite& leaf, const Crown& crown) {
  leaf.at = crown.confine(leaf.at);
  for (int step = 0; step < 3; ++step) {
    const Point tip = leaf.at + leaf.length_m * leaf.along;
    if (crown.contains(tip)) return true;
    leaf.at = crown.confine(leaf.at + (crown.confine(tip) - tip));
  }
  constexpr double kWorthKeeping = 0.3;
  const double wanted = leaf.length_m;
  leaf.length_m = crown.length_inside_m(leaf.at, leaf.along, wanted);
  return leaf.length_m > kWorthKeeping * wanted;
}

}  // namespace

std::vector<LeafSite> fitted_leaves(const Skeleton& grown,
                                    const Skeleton& fitted,
                                    const std::vector<std::uint32_t>& number,
                                    const Crown& crown,
                                    const std::function<Point(Point)>& in_crown) {
  std::vector<LeafSite> leaves;
  if (grown.leaves.empty()) return leaves;
  leaves.reserve(grown.leaves.size());
  const double scale = mean_scale(grown, fitted, number);
  constexpr double kLongest = 0.8;
  for (LeafSite leaf : grown.leaves) {
    if (number[leaf.axis] == kNone) continue;
    if (leaf.axis == 0) {
      leaf.at = in_crown(leaf.at);
    } else {
      move_with_axis(leaf,
                     grown.points_of(grown.axes[leaf.axis]),
                     fitted.points_of(fitted.axes[number[leaf.axis]]),
                     scale);
    }
    leaf.axis = number[leaf.axis];
    leaf.length_m = std::min(scale * leaf.length_m, kLongest);
    if (bring_inside(leaf, crown)) leaves.push_back(leaf);
  }
  return leaves;
}

}  // namespace silvafit::tree
