// SPDX-License-Identifier: MIT
// Plots that cover each other because each has its own coordinate system.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "silvafit/tree/morphology.hpp"

namespace silvafit::tree {

/// Two plots of which one shares more than half of its area with the other; areas are rectangles
/// around the stems. Plots of fewer than three trees, or with all trees on a line to the north or
/// east, have no area.
/// \return two such plots in the order of the trees; nothing if there are none
std::optional<std::pair<std::string, std::string>> coinciding_plots(
    std::span<const Morphology> trees);

}  // namespace silvafit::tree
