// SPDX-License-Identifier: MIT
// Shading of leaves by their position in the crown.
#pragma once

#include <algorithm>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/point.hpp"

namespace silvafit::tree {

/// The crown as an ellipsoid of its width and length. Shading by each leaf alone looks noisy; the
/// crown's shape and light from above look like foliage.
class CrownLight {
 public:
  /// Weight of light from above relative to light from outside.
  static constexpr Point kAbove{0.0, 0.0, 0.35};

  explicit CrownLight(const Crown& crown) {
    const double length = crown.h_m() - crown.hcb_m();
    center_ = {0.0, 0.0, crown.hcb_m() + 0.35 * length};
    across_ = 2.0 / crown.radii().width_m();
    along_ = 2.0 / length;
  }

  /// Away from the inside of the crown; of length 1.
  Point outward(Point at) const { return direction(stretched(at)); }

  /// Amount of light at a point: 0 in the middle, 1 at the ellipsoid and outside.
  double share(Point at) const {
    const Point reach = stretched(at);
    return std::clamp(dot(reach, reach), 0.0, 1.0);
  }

  /// In coordinates in which the ellipsoid is the unit sphere.
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
