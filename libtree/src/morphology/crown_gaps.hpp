// SPDX-License-Identifier: MIT
// The places of a crown that are far from the ends of its branches.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// Of the buds in all directions, those in the light become branches. A new branch therefore ends
/// where it is farthest from the ends of the others, which leaves no large gap in the crown.
class CrownGaps {
 public:
  explicit CrownGaps(const Crown& crown)
      : crown_(&crown), along_(2.0 / std::max(crown.h_m() - crown.hcb_m(), kLeast)) {}

  void occupy(Point end) { ends_.push_back(scaled(end)); }

  /// Squared distance to the stem's axis.
  double squared_from_stem(Point place) const {
    const Point at = scaled(place);
    return at.x * at.x + at.y * at.y;
  }

  /// Squared distance to the nearest end.
  double squared_gap(Point place) const {
    const Point at = scaled(place);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Point& end : ends_) {
      const Point apart = end - at;
      nearest = std::min(nearest, dot(apart, apart));
    }
    return nearest;
  }

  /// The end nearest to a place, and its distance by that of the second nearest.
  struct Nearest {
    std::size_t nearest = 0;
    double ratio = 0.0;
  };
  Nearest two_nearest(Point place) const {
    const Point at = scaled(place);
    Nearest found;
    double first = std::numeric_limits<double>::infinity();
    double second = first;
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const Point apart = ends_[i] - at;
      const double squared = dot(apart, apart);
      if (squared < first) found.nearest = i;
      second = std::min(second, std::max(first, squared));
      first = std::min(first, squared);
    }
    found.ratio = second > 0.0 ? std::sqrt(first / second) : 1.0;
    return found;
  }

  /// In radii of the crown in the same direction, and in halves of its length: otherwise the wide
  /// side of a crown would get all branches.
  Point scaled(Point at) const {
    const double across = 1.0 / crown_->radius_m(at.x, at.y);
    return {across * at.x, across * at.y, along_ * at.z};
  }

 private:
  static constexpr double kLeast = 1e-6;

  const Crown* crown_;
  double along_;
  std::vector<Point> ends_{};
};

}  // namespace silvafit::tree
