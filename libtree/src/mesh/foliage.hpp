// SPDX-License-Identifier: MIT
// Needle sprays and tufts of leaves on the twigs.
#pragma once

#include "mesh/part_builder.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// A frond on each first-order branch: its twigs' needles, tips above and below each twig, and
/// partly filled gaps between them. All of it stays inside the crown.
void add_needles(const Skeleton& skeleton,
                 const Crown& crown,
                 const Foliage& foliage,
                 const MeshOptions& options,
                 PartBuilder& build);

/// Tufts of leaves at the ends of branches, twigs and shoots, and along the outermost of these. All
/// of them stay inside the crown.
void add_leaves(const Skeleton& skeleton,
                const Crown& crown,
                const Foliage& foliage,
                Random& random,
                const MeshOptions& options,
                PartBuilder& build);

}  // namespace silvafit::tree
