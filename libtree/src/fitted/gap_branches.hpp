// SPDX-License-Identifier: MIT
// Branches for the places of a crown that have none.
#pragma once

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Adds a branch wherever a place near the surface of the crown, or halfway to it, is farther than
/// this from all branches. It starts at a branch or at the stem, and is inside the crown. If the
/// skeleton has leaves, so has the branch.
/// \param largest_gap  as FitOptions
void fill_gaps(Skeleton& skeleton, const Crown& crown, double largest_gap);

}  // namespace silvafit::tree
