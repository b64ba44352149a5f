// SPDX-License-Identifier: MIT
// Adjusting a freely grown skeleton to the measurements of a tree.
#pragma once

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/morphology.hpp"
#include "silvafit/tree/skeleton.hpp"
#include "silvafit/tree/taper.hpp"

namespace silvafit::tree {

/// Scales, bends and prunes a skeleton so that height, crown base, DBH and the four crown radii are
/// those of the shape, and all branches and leaf sites are inside the crown.
///
/// The stem is set upright and straight up to breast height and crown base, ends at the tree's
/// height and gets the diameters of the taper equation. If it ends in a fork it continues in the
/// limb that rises highest. The space round it is mapped smoothly onto the crown, height by height;
/// branches that begin below the crown base are moved up. Parts still outside are turned about
/// their base and shortened. In each of the four measured directions a branch ends at the crown's
/// widest point; if there is none, a copy of a branch is turned there. One branch begins
/// at the crown base. Radii of branches keep their ratio to the stem's, but are never larger than
/// that of the parent, nor than 0.15 of the length. Leaves move and turn with their axis,
/// become longer as branches do on average, up to 0.8 m, and are inside with their whole length.
/// The same skeleton gives the same result, for any unit and position.
/// \param grown  the stem first (order 0, from the ground up), of any size; at least one branch
/// \param head   0, or the proportion of the crown's length below which no branch starts, as in a
/// tree fern: branches arch from there to the crown's surface, and the lowest one hangs down to the
/// crown base, where it ends
/// \throws GeometryError if a coordinate is not finite, the stem does not rise, or no branch has a
/// length and a radius
Skeleton fit_to_measurements(const Skeleton& grown,
                             const TreeShape& shape,
                             const Crown& crown,
                             const Taper& taper,
                             double head = 0.0);

}  // namespace silvafit::tree
