// SPDX-License-Identifier: MIT
// A single branch of a tree.
#pragma once

#include "segments/branch_plan.hpp"

namespace silvafit::tree {

/// The stem and one first-order branch with its twigs.
Skeleton grow_branch_skeleton(const TreeShape& shape,
                              const Crown& crown,
                              const Preset& preset,
                              const PlannedBranch& branch,
                              Random& random);

}  // namespace silvafit::tree
