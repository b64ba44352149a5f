// SPDX-License-Identifier: MIT
// Plots that overlap while neighbors are searched across plots.
#pragma once

#include <string>

#include "silvafit/stand/plot_windows.hpp"

namespace silvafit::stand {

/// A note on the plots of a stand that overlap, with one pair of them; empty if none do. Plots
/// overlap if they share more than a thousandth of the smaller one, which is more than rounding
/// of vertices can cause. A plot's area is its window or, if plots share one or have none,
/// the convex hull of its trees.
/// Cost: n log n in the number of plots, and one intersection per plot if all overlap.
std::string note_on_overlapping_plots(const Inventory& inventory, const PlotWindows& windows);

}  // namespace silvafit::stand
