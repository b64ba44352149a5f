// SPDX-License-Identifier: MIT
#include "fitted/leaf_sites.hpp"

#include "fitted/standing_skeleton.hpp"

namespace silvafit::tree {

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
