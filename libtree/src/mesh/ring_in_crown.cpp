// SPDX-License-Identifier: MIT
#include "mesh/ring_in_crown.hpp"

#include <algorithm>

namespace silvafit::tree {

bool RingInCrown::contains(Point at, double radius_m) const {
  return std::ranges::all_of(corners_, [&](const Point& corner) {
    return crown_.contains(at + radius_m * across(corner));
  });
}

/// Of the corners of a ring of radius 1, relative to its center.
double RingInCrown::lowest() const {
  double lowest = 0.0;
  for (const Point& corner : corners_) lowest = std::min(lowest, across(corner).z);
  return lowest;
}

bool RingInCrown::fit(Point& at, double& radius_m, double let_pass_m) const {
  if (contains(at, radius_m)) return true;
  const double low = lowest();
  const double missing = crown_.hcb_m() - (at.z + radius_m * low);
  if (missing > 0.0) at.z += missing;
  at = crown_.confine(at);
  constexpr double kShrink = 0.75;
  while (!contains(at, radius_m)) {
    if (radius_m <= let_pass_m) return false;
    const double smaller = std::max(kShrink * radius_m, 0.99 * let_pass_m);
    if (missing > 0.0) {
      at.z += (radius_m - smaller) * low;
      at = crown_.confine(at);
    }
    radius_m = smaller;
  }
  return true;
}

}  // namespace silvafit::tree
