// SPDX-License-Identifier: MIT
// Edge correction: the core trees and their weights.
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

/// The note on trees outside their windows.
std::string outside_note(std::size_t trees, EdgeCorrection edge);

}  // namespace silvafit::stand
