// SPDX-License-Identifier: MIT
// The branches of a grown skeleton that are bent to the four measured crown radii.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fitted/crown_map.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Displacements of the points of a grown skeleton by which one axis ends at the crown's widest
/// point in the east, west, south and north (directions 0 to 3).
class RadiusAxes {
 public:
  /// -1 if an axis ends at no measured radius.
  int direction_of(std::uint32_t axis) const;

  /// The position of a point of one of these axes, or of their branches.
  CrownPlace led(CrownPlace place, std::uint32_t point) const;

 private:
  friend RadiusAxes lead_to_radii(Skeleton& grown, const CrownMap& map, const Crown& crown);

  /// Increases from 0 at an axis's base to 1 at its tip.
  struct Lead {
    double turn_cos = 1.0;
    double turn_sin = 0.0;
    double out = 0.0;
    double rise_m = 0.0;
    bool is_own = false;  ///< of the axis itself, not of its branches
  };

  std::array<std::uint32_t, 4> axes_{};
  std::vector<Lead> leads_{};  ///< by point
};

/// Selects the four axes with the smallest necessary bend. A direction without a near axis gets a
/// copy of a whole branch, rotated about the stem.
/// \param grown  upright; the copies are added
RadiusAxes lead_to_radii(Skeleton& grown, const CrownMap& map, const Crown& crown);

}  // namespace silvafit::tree
