// SPDX-License-Identifier: MIT
// Leaves that move with their axes.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// The leaves of a grown skeleton on the fitted one: each is moved and turned with the piece of its
/// axis that is nearest to it, scaled by the ratio by which all branches together became longer,
/// and moved towards the stem's axis until its tip is inside the crown too. Leaves of the stem
/// itself keep their orientation.
/// \param number    of each grown axis in the fitted skeleton; none: 2^32 - 1
/// \param in_crown  the map of the grown skeleton's space to the crown
std::vector<LeafSite> fitted_leaves(const Skeleton& grown,
                                    const Skeleton& fitted,
                                    const std::vector<std::uint32_t>& number,
                                    const Crown& crown,
                                    const std::function<Point(Point)>& in_crown);

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
