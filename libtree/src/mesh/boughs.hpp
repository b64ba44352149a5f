// SPDX-License-Identifier: MIT
// The parts into which a crown divides.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "morphology/crown_gaps.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Each branch of the stem bears a small crown of its own. The whole reaches the crown's surface
/// where a branch ends, and is lower between two: light falls into these grooves, through which one
/// sees limbs and sky.
class Boughs {
 public:
  /// \param groove  depth of the grooves by the crown's radius; 0: the crown is one
  Boughs(const Skeleton& skeleton, const Crown& crown, double groove)
      : crown_(crown), middle_{0.0, 0.0, crown.hc_m()}, groove_(groove), ends_(crown) {
    if (!(groove > 0.0)) return;
    for (const Axis& axis : skeleton.axes) {
      if (axis.order > 1) continue;
      const Point end = skeleton.points_of(axis).back().at;
      ends_.occupy(end);
      constexpr double kDeep = 0.65;
      cores_.push_back(middle_ + kDeep * (end - middle_));
    }
  }

  /// Whether a place of the crown is below the domes of its boughs.
  bool contain(Point place) const {
    if (cores_.size() < 2) return true;
    const double away = ends_.two_nearest(place).ratio;
    const double height = 1.0 - groove_ * (1.0 - std::sqrt(std::max(1.0 - away * away, 0.0)));
    return crown_.contains(middle_ + 1.0 / height * (place - middle_));
  }

  /// Away from the inside of the bough, of length 1; without grooves 0.
  Point outward(Point at) const {
    if (cores_.size() < 2) return {};
    return direction(at - cores_[ends_.two_nearest(at).nearest]);
  }

 private:
  const Crown& crown_;
  Point middle_;
  double groove_;
  CrownGaps ends_;
  std::vector<Point> cores_{};
};

}  // namespace silvafit::tree
