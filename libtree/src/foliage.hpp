// SPDX-License-Identifier: MIT
// Needle sprays and leaf sprays on the twigs.
#pragma once

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// Adds the foliage of all twigs and branch ends; all of it stays inside the crown.
void add_foliage(const Skeleton& skeleton,
                 const Crown& crown,
                 const Foliage& foliage,
                 Random& random,
                 MeshPart& part);

}  // namespace silvafit::tree
