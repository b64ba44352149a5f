// SPDX-License-Identifier: MIT
// Which trees of a table stand in a scene, by their names and places.
#pragma once

#include <string>
#include <vector>

#include "silvafit/tree/scene_reader.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {

/// Gives the trees of a table their nodes and instances in the scene. A node is found by its name
/// plot-tree, an instance by its place; both must stand where the table has the tree, within 5 cm
/// in plan, so that measurements of other trees are never shown. An instance whose place fits more
/// than one tree takes that of its number if it is one of them, and else none; a tree that fits
/// more than one instance takes none. What is not found is noted.
/// \param nodes  names of all nodes of the file, in its order
/// \throws InputError if no tree is found, or fewer instances than half the scene's or the table's
/// trees, whichever are fewer
void match_trees(ViewStand& stand,
                 const std::vector<std::string>& nodes,
                 const tree::ReadScene& scene);

}  // namespace silvafit::study
