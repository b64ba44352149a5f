// SPDX-License-Identifier: MIT
// Whether the overlaps of a stand can be resolved, before its trees are grown.
#pragma once

#include <span>

#include "silvafit/tree/morphology.hpp"

namespace silvafit::tree {

/// Checks that resolve_overlaps() can resolve the overlaps of these trees.
/// \param threads  0: one for each core
/// \throws GeometryError with the tree if more crowns meet in one place than can be resolved in a
///   reasonable time
void check_crown_density(std::span<const Morphology> trees, unsigned threads = 0);

}  // namespace silvafit::tree
