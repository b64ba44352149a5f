// SPDX-License-Identifier: MIT
// Plots that lie on each other, where neighbors are searched across plots.
#pragma once

#include <string>

#include "silvafit/stand/plot_windows.hpp"

namespace silvafit::stand {

/// A note of the plots of a stand that overlap, with a pair of them; empty if none do. Plots
/// overlap if they share more than a thousandth of the smaller one, which is beyond what rounding
/// of corners does to borders. A plot's area is its window or, where plots share one or have none,
/// the convex hull of its trees.
/// Cost: n log n in the number of plots, and one intersection a plot where all overlap.
std::string note_on_overlapping_plots(const Inventory& inventory, const PlotWindows& windows);

}  // namespace silvafit::stand
