// SPDX-License-Identifier: MIT
// How leaves are lit: by where they are in the crown.
#pragma once

#include <algorithm>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// The crown as an ellipsoid of its width and length. Leaves that are lit one by one flicker; the
/// crown's own shape and light from above make them read as foliage.
class CrownLight {
 public:
  /// What light from above adds to that from outside, whose length is about 1.
  static constexpr Point kAbove{0.0, 0.0, 0.35};

  explicit CrownLight(const Crown& crown) {
    const double length = crown.h_m() - crown.hcb_m();
    center_ = {0.0, 0.0, crown.hcb_m() + 0.35 * length};
    across_ = 2.0 / crown.radii().width_m();
    along_ = 2.0 / length;
  }

  /// Away from the crown's inside; of length 1.
  Point outward(Point at) const { return direction(stretched(at)); }

  /// How much light a place gets: 0 in the middle, 1 at the ellipsoid and beyond.
  double share(Point at) const {
    const Point reach = stretched(at);
    return std::clamp(dot(reach, reach), 0.0, 1.0);
  }

  /// In a frame where the ellipsoid is the sphere of radius 1.
  Point stretched(Point at) const {
    return {
        (at.x - center_.x) * across_, (at.y - center_.y) * across_, (at.z - center_.z) * along_};
  }

 private:
  Point center_{};
  double across_ = 1.0;
  double along_ = 1.0;
};

}  // namespace silvafit::tree
