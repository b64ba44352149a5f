// SPDX-License-Identifier: MIT
#include "fitted/fitted_leaves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fitted/standing_skeleton.hpp"
#include "segments/skeleton_line.hpp"

namespace silvafit::tree {
namespace {

/// Sum of the lengths of all branches in the grown and in the fitted skeleton.
double mean_scale(const Skeleton& grown,
                  const Skeleton& fitted,
                  const std::vector<std::uint32_t>& number) {
  double before = 0.0;
  double after = 0.0;
  for (std::size_t i = 1; i < grown.axes.size(); ++i) {
    before += line_length_m(grown.points_of(grown.axes[i]));
    if (number[i] != kNone) after += line_length_m(fitted.points_of(fitted.axes[number[i]]));
  }
  return before > 0.0 ? after / before : 1.0;
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
      const auto was = grown.points_of(grown.axes[leaf.axis]);
      const auto now = fitted.points_of(fitted.axes[number[leaf.axis]]);
      const auto [k, part] = nearest_place(was, leaf.at);
      const Point before = was[k + 1].at - was[k].at;
      const Point after = now[k + 1].at - now[k].at;
      move_with(leaf, before, after, was[k].at + part * before, now[k].at + part * after, scale);
    }
    leaf.axis = number[leaf.axis];
    leaf.length_m = std::min(scale * leaf.length_m, kLongest);
    if (bring_inside(leaf, crown)) leaves.push_back(leaf);
  }
  return leaves;
}

void move_with(LeafSite& leaf, Point was, Point now, Point from, Point to, double scale) {
  const Point before = direction(was);
  const Point after = direction(now, before);
  leaf.at = to + scale * turned_with(leaf.at - from, before, after);
  leaf.along = direction(turned_with(leaf.along, before, after));
  leaf.facing = turned_with(leaf.facing, before, after);
  leaf.facing = direction(leaf.facing - dot(leaf.facing, leaf.along) * leaf.along);
}

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

}  // namespace silvafit::tree
