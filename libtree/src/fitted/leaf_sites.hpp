// SPDX-License-Identifier: MIT
// Leaves that go where their axis goes.
#pragma once

#include <span>

#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// Moves and turns a leaf with the piece of its axis at which it grows.
/// \param was   that piece before, from its lower to its upper end
/// \param now   and after
/// \param from  the place in the piece where the leaf grows, before
/// \param to    and after
/// \param scale  of the leaf's distance from its axis
void move_with(LeafSite& leaf, Point was, Point now, Point from, Point to, double scale);

/// Moves a leaf that reaches out of the crown in, towards the stem's axis, and shortens it where
/// that is not enough.
/// \return whether enough is left of it
bool bring_inside(LeafSite& leaf, const Crown& crown);

}  // namespace silvafit::tree
