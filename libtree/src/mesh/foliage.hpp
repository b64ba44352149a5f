// SPDX-License-Identifier: MIT
// Needle sprays and tufts of leaves on the twigs.
#pragma once

#include "mesh/part_builder.hpp"
#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Adds the foliage of all twigs and branch ends; all of it stays inside the crown.
void add_foliage(const Skeleton& skeleton,
                 const Crown& crown,
                 const Foliage& foliage,
                 Random& random,
                 const MeshOptions& options,
                 PartBuilder& build);

/// A frond on each first-order branch: its twigs' needles, tips above and below each twig, and
/// partly filled gaps between them.
void add_needles(const Skeleton& skeleton,
                 const Crown& crown,
                 const Foliage& foliage,
                 Random& random,
                 const MeshOptions& options,
                 PartBuilder& build);

/// Tufts of leaves at the ends of branches, twigs and shoots, and along the outermost of these.
void add_leaves(const Skeleton& skeleton,
                const Crown& crown,
                const Foliage& foliage,
                Random& random,
                const MeshOptions& options,
                PartBuilder& build);

}  // namespace silvafit::tree
