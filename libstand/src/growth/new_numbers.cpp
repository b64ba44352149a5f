// SPDX-License-Identifier: MIT
// Plots in which trees got new numbers between two visits.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "growth/growth_parts.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/median.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

/// In a smaller plot all trees may really be others.
constexpr std::size_t kFewestTrees = 3;

/// After a clear-cut the new trees are thinner than the old ones.
constexpr double kSimilarSize = 0.75;

/// More than the mean tree of most stands grows; clones of poplar and eucalypts reach 4 cm.
constexpr double kFastCmPerYear = 2.0;

bool comes_again(const MeasuredTree& tree, std::size_t next) {
  const auto has_row = [](const auto& row) { return row.has_value(); };
  const auto middle = tree.rows.begin() + static_cast<std::ptrdiff_t>(next);
  return std::any_of(tree.rows.begin(), middle, has_row) &&
         std::any_of(middle, tree.rows.end(), has_row);
}

std::vector<double> dbh_at(const MeasuredPlot& plot,
                           std::size_t occasion,
                           const Inventory& inventory) {
  std::vector<double> dbh_cm;
  for (const MeasuredTree& tree : plot.trees) {
    const auto& row = tree.rows[occasion];
    if (row && !std::isnan(inventory.dbh_cm[*row])) dbh_cm.push_back(inventory.dbh_cm[*row]);
  }
  return dbh_cm;
}

/// Whether trees have new numbers from an occasion on.
bool has_new_numbers(const MeasuredPlot& plot, std::size_t next, const Inventory& inventory) {
  const auto again = [next](const MeasuredTree& tree) { return comes_again(tree, next); };
  if (std::ranges::any_of(plot.trees, again)) return false;
  const std::vector<double> before = dbh_at(plot, next - 1, inventory);
  const std::vector<double> after = dbh_at(plot, next, inventory);
  if (std::min(before.size(), after.size()) < kFewestTrees) return false;
  const double years = plot.occasions[next].years - plot.occasions[next - 1].years;
  const double typical_cm = median(after);
  return typical_cm >= kSimilarSize * median(before) && typical_cm > kFastCmPerYear * years;
}

}  // namespace

void refuse_new_numbers(const std::vector<MeasuredPlot>& plots, const Inventory& inventory) {
  std::vector<std::string> found;
  for (const MeasuredPlot& plot : plots) {
    for (std::size_t k = 1; k < plot.occasions.size(); ++k) {
      if (!has_new_numbers(plot, k, inventory)) continue;
      found.push_back(fmt::format(
          "plot {} ({} to {})", plot.plot, plot.occasions[k - 1].text, plot.occasions[k].text));
    }
  }
  if (found.empty()) return;
  const auto column = inventory.label_columns.find("tree");
  throw InputError(
      fmt::format(
          "no tree comes again in {}, although the later trees are too thick to be new: {}; "
          "trees must keep their numbers; if all were cut or died, give them a row with a "
          "status, or leave the plots out with `where`",
          counted(found.size(), "period of a plot", "periods of plots"),
          data::list_of(found)),
      {.file = inventory.file,
       .column = column == inventory.label_columns.end() ? "tree" : column->second});
}

}  // namespace silvafit::stand
