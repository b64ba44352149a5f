// SPDX-License-Identifier: MIT
// Edge correction: which trees are core trees, and how much each counts.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/stand/structural_units.hpp"

namespace silvafit::stand {

/// Sets core and weight, and adds findings. Neighbors must have been found.
/// \param inside  (N) whether each tree is inside its window
void correct_edge(const Inventory& inventory,
                  const PlotWindows& windows,
                  const std::vector<char>& inside,
                  const StructuralUnitOptions& options,
                  StructuralUnits& units);

/// What is said of trees that stand outside their windows.
std::string outside_note(std::size_t trees, EdgeCorrection edge);

}  // namespace silvafit::stand
