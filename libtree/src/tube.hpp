// SPDX-License-Identifier: MIT
// Tubes around axes.
#pragma once

#include <span>

#include "silvafit/tree/mesh.hpp"

namespace silvafit::tree {

/// A closed tube around the vertical stem, its sections as large as the circles they stand for.
void add_stem(std::span<const SkeletonPoint> axis, const MeshOptions& options, MeshPart& part);

/// A tube around a branch that is open at its base, inside the parent, and ends in a point. Its
/// vertices stay inside the crown.
void add_branch(std::span<const SkeletonPoint> axis, int sides, const Crown& crown, MeshPart& part);

}  // namespace silvafit::tree
