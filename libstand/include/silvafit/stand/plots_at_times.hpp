// SPDX-License-Identifier: MIT
// Plots that were measured several times, each time as a plot of its own.
#pragma once

#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/sampling_design.hpp"
#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// A plot at one of its times, as written.
struct PlotAtTime {
  std::string plot{};
  std::string time{};
};

/// The plots of an inventory at their times, in the order of their first rows.
/// \param inventory  read with InventoryOptions::period
std::vector<PlotAtTime> plots_at_times(const Inventory& inventory);

/// Windows for an inventory whose plots have labels such as "7 (2019)": the window of a plot
/// belongs to the plot at each of its times. A window without a plot belongs to the only plot.
/// \throws UsageError if it is given for several plots
std::vector<NamedWindow> windows_at_times(const std::vector<NamedWindow>& windows,
                                          const std::vector<PlotAtTime>& plots);

/// The design with the rows of its table of plots for each plot at each time. Rows with a year or
/// date belong to the measurements of that time, others to all times of their plot; a plot without
/// trees at its time is an empty one.
SamplingDesign design_at_times(SamplingDesign design, const std::vector<PlotAtTime>& plots);

}  // namespace silvafit::stand
