// SPDX-License-Identifier: MIT
// Leaves that follow the axes that bear them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "silvafit/tree/skeleton.hpp"

namespace silvafit::tree {

/// The leaves of a grown skeleton on the fitted one: each is moved and turned with the piece of its
/// axis that is nearest to it, scaled by as much as all branches together became longer, and moved
/// in towards the stem's axis until its tip is inside the crown too. Leaves of the stem itself
/// stand as they grew.
/// \param number    of each grown axis in the fitted skeleton; none: 2^32 - 1
/// \param in_crown  where a place of the grown skeleton's space comes to in the crown
std::vector<LeafSite> fitted_leaves(const Skeleton& grown,
                                    const Skeleton& fitted,
                                    const std::vector<std::uint32_t>& number,
                                    const Crown& crown,
                                    const std::function<Point(Point)>& in_crown);

}  // namespace silvafit::tree
