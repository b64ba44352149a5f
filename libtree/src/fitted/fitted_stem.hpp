// SPDX-License-Identifier: MIT
// The stem of a tree with measured height and diameter that keeps the bends of a grown one.
#pragma once

#include <vector>

#include "fitted/crown_map.hpp"
#include "silvafit/tree/taper.hpp"

namespace silvafit::tree {

/// Sections as the builder of segments makes them, by the taper equation. Straight up to breast
/// height and to the crown base; above it the stem winds as it grew, in proportion to the crown's
/// width and within its inner third, and comes back to the axis at the tip.
std::vector<SkeletonPoint> fitted_stem(const StandingSkeleton& grown,
                                       const CrownMap& map,
                                       const TreeShape& shape,
                                       const Crown& crown,
                                       const Taper& taper);

}  // namespace silvafit::tree
