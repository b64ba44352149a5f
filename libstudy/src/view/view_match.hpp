// SPDX-License-Identifier: MIT
// Matching of a table's trees with a scene, by names and positions.
#pragma once

#include "silvafit/tree/scene_reader.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {

/// Gives the trees of a table their nodes and instances in the scene. A node is found by its name
/// plot-tree, an instance by its position; both must have the position of the tree in the table,
/// within 5 cm in x and y, so that measurements of other trees are never shown. An instance that
/// matches more than one tree by position gets that of its number if it is one of them, and else
/// none; a tree that matches more than one instance gets none. Notes count trees without a match.
/// \throws InputError if no tree is found, or fewer instances than half the scene's or the table's
/// trees, whichever are fewer
void match_trees(ViewStand& stand, const tree::ReadScene& scene);

}  // namespace silvafit::study
