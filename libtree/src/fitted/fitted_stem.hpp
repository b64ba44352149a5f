// SPDX-License-Identifier: MIT
// The stem of a tree with measured height and diameter and the bends of a grown stem.
#pragma once

#include <vector>

#include "fitted/crown_map.hpp"
#include "silvafit/tree/taper.hpp"

namespace silvafit::tree {

/// Sections as in the segment builder, by the taper equation. Straight up to breast height and to
/// the crown base; above, the stem keeps its grown bends, in proportion to the crown's width and
/// within its inner third, and returns to the axis at the tip.
std::vector<SkeletonPoint> fitted_stem(const StandingSkeleton& grown,
                                       const CrownMap& map,
                                       const TreeShape& shape,
                                       const Crown& crown,
                                       const Taper& taper);

}  // namespace silvafit::tree
