// SPDX-License-Identifier: MIT
// Roots that hang from limbs, and those that have become props.
#pragma once

#include "mesh/part_builder.hpp"
#include "mesh/smooth_mesh_limbs.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/tree/smooth_mesh.hpp"

namespace silvafit::tree {

/// Adds roots at about equal distances along the outer part of the limbs that are drawn as wood.
///
/// A root starts inside its limb and grows down. Props end at the ground, wider at their foot; the
/// others end above it in a point. Each root is a closed tube.
void add_aerial_roots(const Skeleton& skeleton,
                      const Limbs& limbs,
                      const AerialRoots& roots,
                      Random& random,
                      const MeshOptions& options,
                      PartBuilder& build);

}  // namespace silvafit::tree
