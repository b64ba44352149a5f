// SPDX-License-Identifier: MIT
#include "mesh/ring_in_crown.hpp"

#include <algorithm>
#include <cmath>

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

/// Near a direction in which the crown is much narrower, a tiny change of azimuth matters.
bool RingInCrown::move_inward(Point& at, double radius_m, double step_m) const {
  constexpr int kMostSteps = 12;
  for (int i = 1; i <= kMostSteps && !contains(at, radius_m); ++i) {
    const double away = std::hypot(at.x, at.y);
    const double nearer = std::max(away - step_m * i, 0.0) / std::max(away, step_m);
    at = crown_.confine({nearer * at.x, nearer * at.y, at.z});
  }
  return contains(at, radius_m);
}

bool RingInCrown::fit(Point& at, double& radius_m, double let_pass_m) const {
  if (contains(at, radius_m)) return true;
  const double low = lowest();
  const double missing = crown_.hcb_m() - (at.z + radius_m * low);
  if (missing > 0.0) at.z += missing;
  at = crown_.confine(at);
  constexpr double kShrink = 0.75;
  while (!contains(at, radius_m)) {
    if (radius_m <= let_pass_m) return move_inward(at, radius_m, let_pass_m);
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
