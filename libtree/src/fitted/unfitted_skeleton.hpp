// SPDX-License-Identifier: MIT
// Freely grown skeletons that are drawn as they are, at the size of a tree.
#pragma once

#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// The same skeleton with the stem's base at the origin and the highest point of its axes at a
/// height; all directions and ratios of lengths and radii are kept.
/// \throws GeometryError if a coordinate is not finite, there is no branch, or nothing rises above
/// the stem's base
Skeleton scaled_to_height(Skeleton grown, double h_m);

/// The extent of a skeleton: height, lowest point of the branches, and radii in the four
/// directions.
TreeShape shape_of(const Skeleton& skeleton);

}  // namespace silvafit::tree
