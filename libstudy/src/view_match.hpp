// SPDX-License-Identifier: MIT
// Which trees of a table stand in a scene, by their names and places.
#pragma once

#include <string>
#include <vector>

#include "silvafit/tree/scene_reader.hpp"
#include "view_stand.hpp"

namespace silvafit::study {

/// Gives the trees of a table their nodes and instances in the scene. A node is found by its name
/// plot-tree, an instance by its place; both must stand where the table has the tree, within 5 cm
/// in plan, so that measurements of other trees are never shown. Instances whose place fits more
/// than one tree, or trees that fit more than one instance, take the tree of their number if that
/// is one of them, and else none. What is not found is noted.
/// \param nodes  names of all nodes of the file, in its order
/// \throws InputError if fewer than half of the scene's trees, or of the table's, are found
void match_trees(ViewStand& stand,
                 const std::vector<std::string>& nodes,
                 const tree::ReadScene& scene);

}  // namespace silvafit::study
