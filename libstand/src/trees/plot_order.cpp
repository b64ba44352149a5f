// SPDX-License-Identifier: MIT
#include "trees/plot_order.hpp"

#include <algorithm>
#include <numeric>

namespace silvafit::stand {

std::vector<std::uint32_t> plots_in_order(const Inventory& inventory) {
  std::vector<std::uint32_t> plots(inventory.plot.levels().size());
  std::iota(plots.begin(), plots.end(), 0U);
  // Labels of other places than plots, such as subplots, have no lines.
  if (inventory.plot_lines.size() != plots.size()) return plots;
  std::ranges::stable_sort(
      plots, {}, [&](std::uint32_t plot) { return inventory.plot_lines[plot]; });
  return plots;
}

std::vector<std::size_t> rows_in_plot_order(const Inventory& inventory) {
  const std::vector<std::uint32_t> plots = plots_in_order(inventory);
  std::vector<std::size_t> place(plots.size());
  for (std::size_t i = 0; i < plots.size(); ++i) place[plots[i]] = i;
  std::vector<std::size_t> rows(inventory.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  std::ranges::stable_sort(
      rows, {}, [&](std::size_t row) { return place[inventory.plot.code(row)]; });
  return rows;
}

}  // namespace silvafit::stand
