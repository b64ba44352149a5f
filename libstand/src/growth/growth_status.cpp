// SPDX-License-Identifier: MIT
// The status of trees at each time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "growth/growth_maker.hpp"
#include "silvafit/base/text.hpp"

namespace silvafit::stand {
namespace {

/// Whether all rows of a tree have the same status.
bool has_one_status(const MeasuredTree& tree, const std::vector<TreeStatus>& status) {
  std::optional<TreeStatus> first;
  return std::ranges::all_of(tree.rows, [&](const std::optional<std::size_t>& row) {
    if (!row) return true;
    if (!first) first = status[*row];
    return status[*row] == *first;
  });
}

/// Makes a tree alive up to its last dbh before the last visit of its plot.
bool revive_before_last(const MeasuredTree& tree,
                        const Inventory& inventory,
                        std::vector<TreeStatus>& status) {
  const auto is_dead_with_dbh = [&](const std::optional<std::size_t>& row) {
    return row && status[*row] != TreeStatus::kAlive && !std::isnan(inventory.dbh_cm[*row]);
  };
  std::size_t end = tree.rows.empty() ? 0 : tree.rows.size() - 1;
  while (end > 0 && !is_dead_with_dbh(tree.rows[end - 1])) --end;
  for (std::size_t k = 0; k < end; ++k) {
    if (tree.rows[k]) status[*tree.rows[k]] = TreeStatus::kAlive;
  }
  return end > 0;
}

}  // namespace

/// A column whose status never changes between the rows of a tree has that of the last visit: it
/// was made for the tree, as in a table of a row per tree. A tree with a dbh before was alive then.
void GrowthMaker::read_status() {
  status_ = inventory_.status;
  const auto column = inventory_.label_columns.find("status");
  if (status_.empty() || column == inventory_.label_columns.end()) return;
  const bool is_constant = std::ranges::all_of(plots_, [this](const MeasuredPlot& plot) {
    return std::ranges::all_of(plot.trees, [this](const MeasuredTree& tree) {
      return has_one_status(tree, inventory_.status);
    });
  });
  if (!is_constant) return;
  std::size_t revived = 0;
  for (const MeasuredPlot& plot : plots_) {
    for (const MeasuredTree& tree : plot.trees) {
      revived += revive_before_last(tree, inventory_, status_) ? 1 : 0;
    }
  }
  is_status_of_last_visit_ = revived > 0;
  if (revived == 0) return;
  report_.notes.push_back(fmt::format(
      "the status in column {} never changes between the rows of a tree and is that of the last "
      "visit: {} alive at earlier visits with a dbh; if it is that of each row, leave the rows of "
      "dead trees out with `where`",
      column->second,
      counted(revived, "dead or cut tree was", "dead or cut trees were")));
}

}  // namespace silvafit::stand
