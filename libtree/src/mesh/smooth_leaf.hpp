// SPDX-License-Identifier: MIT
// Single leaves, sprays and cards at the leaf sites of a skeleton.
#pragma once

#include "mesh/part_builder.hpp"
#include "mesh/smooth_mesh_limbs.hpp"
#include "silvafit/tree/crown.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// \throws UsageError as build_smooth_mesh()
void check_looks(const Skeleton& skeleton, const SmoothStyle& style);

/// Mean color of the leaves.
Color leaf_material(const Skeleton& skeleton, const SmoothStyle& style);

/// Adds the leaves of the sites that a level of detail shows. All their vertices are inside the
/// crown.
void add_site_leaves(const Skeleton& skeleton,
                     const Limbs& limbs,
                     const Crown& crown,
                     const SmoothStyle& style,
                     const MeshOptions& options,
                     PartBuilder& build);

}  // namespace silvafit::tree
