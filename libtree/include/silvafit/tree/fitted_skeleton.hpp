// SPDX-License-Identifier: MIT
// Bringing a freely grown skeleton to the measurements of a tree.
#pragma once

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/skeleton.hpp"
#include "silvafit/tree/taper.hpp"

namespace silvafit::tree {

/// Scales, bends and prunes a skeleton so that height, crown base, DBH and the four crown radii are
/// those of the shape, and all branches and leaf sites lie inside the crown.
///
/// The stem becomes upright below breast height, ends at the tree's height and gets the diameters
/// of the taper equation; the radii of branches keep their share of the stem's. Branches that begin
/// below the crown base move up with their place on the stem. In each of the four measured
/// directions one branch ends on the crown's widest point, and something of a branch or leaf is at
/// the crown base.
/// \param grown  the stem first (order 0, from the ground up), of any size; at least one branch
/// \throws GeometryError if it has no stem that rises, or no branch
Skeleton fit_to_measurements(Skeleton grown,
                             const TreeShape& shape,
                             const Crown& crown,
                             const Taper& taper);

}  // namespace silvafit::tree
