// SPDX-License-Identifier: MIT
// The order in which plots are added to sums: that of their first rows in the file, in which they
// also come if the file is read in parts of whole plots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// The codes of the plots in the order of their first rows.
std::vector<std::uint32_t> plots_in_order(const Inventory& inventory);

/// The rows of the trees, plot by plot in this order; within a plot in that of the file.
std::vector<std::size_t> rows_in_plot_order(const Inventory& inventory);

}  // namespace silvafit::stand
