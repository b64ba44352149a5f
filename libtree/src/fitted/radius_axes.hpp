// SPDX-License-Identifier: MIT
// The branches of a grown skeleton that are led to the four measured crown radii.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fitted/crown_map.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// How places of the grown skeleton's points change so that one axis ends at the crown's widest
/// place east, west, south and north (directions 0 to 3).
class RadiusAxes {
 public:
  /// -1 where an axis ends at no measured radius.
  int direction_of(std::uint32_t axis) const;

  /// The place of a point that belongs to one of these axes, or to what grows from them.
  CrownPlace led(CrownPlace place, std::uint32_t point) const;

 private:
  friend RadiusAxes lead_to_radii(Skeleton& grown, const CrownMap& map, const Crown& crown);

  /// Grows from nothing at an axis's base to all of it at its tip.
  struct Lead {
    double turn_cos = 1.0;
    double turn_sin = 0.0;
    double out = 0.0;
    double rise_m = 0.0;
    bool is_own = false;  ///< of the axis itself, not of what it bears
  };

  std::array<std::uint32_t, 4> axes_{};
  std::vector<Lead> leads_{};  ///< by point
};

/// Chooses the four axes that have to be bent least. A direction that no axis is near gets a copy
/// of a whole branch, turned about the stem.
/// \param grown  upright; gains the copies
RadiusAxes lead_to_radii(Skeleton& grown, const CrownMap& map, const Crown& crown);

}  // namespace silvafit::tree
