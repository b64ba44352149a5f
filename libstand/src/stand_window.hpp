// SPDX-License-Identifier: MIT
// Which trees are core trees: each tree's window and its distance from the boundary.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "silvafit/stand/structural_units.hpp"

namespace silvafit::stand {

/// Adds notes on assumed windows and on trees outside.
/// \param positions  (N), NaN where a tree has none
/// \return           (N) 1 for core trees
std::vector<char> core_trees(const Inventory& inventory,
                             std::span<const Point> positions,
                             const StructuralUnitOptions& options,
                             std::vector<std::string>& notes);

}  // namespace silvafit::stand
