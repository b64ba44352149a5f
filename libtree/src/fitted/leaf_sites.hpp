// SPDX-License-Identifier: MIT
// Leaves that move with their axis.
#pragma once

#include <span>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Moves and turns a leaf with the piece of its axis at which it grows.
/// \param was   the piece before, from its lower to its upper end
/// \param now   and after
/// \param from  the position in the piece where the leaf grows, before
/// \param to    and after
/// \param scale  of the leaf's distance from its axis
void move_with(LeafSite& leaf, Point was, Point now, Point from, Point to, double scale);

/// Moves a leaf that reaches out of the crown towards the stem's axis, and shortens it if that is
/// not enough.
/// \return whether enough of it is left
bool bring_inside(LeafSite& leaf, const Crown& crown);

}  // namespace silvafit::tree
