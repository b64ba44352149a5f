// SPDX-License-Identifier: MIT
#include "workflow/repeated_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/row_contents.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/repeated_trees.hpp"
#include "silvafit/stand/size_units.hpp"

namespace silvafit::study {
namespace {

using Rows = std::vector<std::size_t>;

/// The rows of each tree that has several.
std::vector<Rows> rows_of_trees(const data::TextColumn& plot, const data::TextColumn& tree) {
  Rows rows;
  for (std::size_t row = 0; row < plot.size(); ++row) {
    if (!plot.is_missing(row) && !tree.is_missing(row)) rows.push_back(row);
  }
  const auto id = [&](std::size_t row) { return std::pair(plot.code(row), tree.code(row)); };
  std::ranges::stable_sort(rows, {}, id);
  std::vector<Rows> trees;
  for (auto begin = rows.begin(); begin != rows.end();) {
    const auto end =
        std::find_if(begin, rows.end(), [&](std::size_t row) { return id(row) != id(*begin); });
    if (end - begin > 1) trees.emplace_back(begin, end);
    begin = end;
  }
  return trees;
}

struct Copy {
  std::size_t row = 0;
  std::size_t original = 0;  ///< the first row with the same values
};

std::vector<Copy> copies_in(const data::Table& table, const std::vector<Rows>& trees) {
  std::vector<Copy> copies;
  const std::vector<std::uint64_t> contents = data::row_contents(table);
  for (const Rows& rows : trees) {
    std::map<std::uint64_t, std::size_t> originals;
    for (const std::size_t row : rows) {
      const auto [original, is_new] = originals.try_emplace(contents[row], row);
      if (!is_new) copies.push_back({.row = row, .original = original->second});
    }
  }
  std::ranges::sort(copies, {}, &Copy::row);
  return copies;
}

/// The labels of some rows in a column; empty if there is no such column.
data::TextColumn labels_in(const std::optional<std::string>& column,
                           const data::Table& table,
                           const Rows& rows) {
  data::TextColumn labels;
  if (!column) return labels;
  const data::TextColumn all = table.labels(*column);
  for (const std::size_t row : rows) {
    all.is_missing(row) ? labels.append_missing() : labels.append(all[row]);
  }
  return labels;
}

/// Counts the rows of trees beside their first ones at each time, and those of further times.
void count_further_rows(const data::Table& table,
                        const std::vector<Rows>& trees,
                        RepeatCounts& counts) {
  const auto time = stand::usual_time_column(table.names());
  const data::TextColumn times = time ? table.labels(*time) : data::TextColumn();
  for (const Rows& rows : trees) {
    std::set<std::uint32_t> seen;
    for (const std::size_t row : rows) seen.insert(time ? times.code(row) : 0);
    counts.others += rows.size() - seen.size();
    counts.later += seen.size() - 1;
  }
}

Place place_in(const data::Table& table,
               const data::TextColumn& plot,
               const data::TextColumn& tree,
               std::size_t row) {
  Place place{.file = table.file(), .plot = std::string(plot[row]), .tree = std::string(tree[row])};
  if (table.line(row) > 0) place.line = table.line(row);
  return place;
}

/// The place of a copy and of its original.
std::string describe_copy(const Copy& copy,
                          const data::Table& table,
                          const data::TextColumn& plot,
                          const data::TextColumn& tree) {
  const std::size_t line = table.line(copy.original);
  return describe(place_in(table, plot, tree, copy.row),
                  line > 0 ? fmt::format("copy of line {}", line) : "copy of an earlier row");
}

/// The rows with a plot and a tree, and the values needed to compare them.
stand::Inventory inventory_of(const data::Table& table,
                              const Rows& rows,
                              const data::TextColumn& plot,
                              const data::TextColumn& tree,
                              const std::optional<std::string>& species_column,
                              const MeasureOf& measure) {
  stand::Inventory inventory;
  inventory.file = table.file();
  const std::vector<std::uint64_t> contents = data::row_contents(table);
  for (const std::size_t row : rows) {
    inventory.plot.append(plot[row]);
    inventory.tree.append(tree[row]);
    inventory.contents.push_back(contents[row]);
  }
  inventory.species = labels_in(species_column, table, rows);
  for (const stand::TreeColumn& column : stand::tree_columns()) {
    if (!column.is_measure()) continue;
    const std::vector<double> values = measure(std::string(column.name));
    if (values.size() != table.rows()) continue;
    for (const std::size_t row : rows) (inventory.*column.values).push_back(values[row]);
  }
  inventory.dbh_cm.resize(rows.size(), data::kMissing);
  inventory.stem = labels_in(stand::usual_stem_column(table.names()), table, rows);
  return inventory;
}

}  // namespace

std::vector<std::string> RepeatCounts::notes() const {
  std::vector<std::string> notes;
  if (copies > 0) {
    notes.push_back(
        fmt::format("{} of an earlier row of the same plot and tree and used once, the first: {}",
                    counted(copies, "row is a copy", "rows are copies"),
                    first_copy));
  }
  if (others > 0) {
    notes.push_back(
        fmt::format("{} the plot and tree of another row with other values; each is an observation",
                    counted(others, "row has", "rows have")));
  }
  if (later > 0) {
    notes.push_back(fmt::format("{} again at another time, as observations of their own",
                                counted(later, "row measures a tree", "rows measure trees")));
  }
  return notes;
}

void find_copies(const std::string& plot_column,
                 const std::string& tree_column,
                 ObservedTable& read,
                 RepeatCounts& counts) {
  const data::Table& table = read.table;
  const data::TextColumn plot = table.labels(plot_column);
  const data::TextColumn tree = table.labels(tree_column);
  const std::vector<Rows> trees = rows_of_trees(plot, tree);
  const std::vector<Copy> copies = copies_in(table, trees);
  count_further_rows(table, trees, counts);
  counts.others -= copies.size();
  if (copies.empty()) return;
  auto copy = copies.begin();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool is_copy = copy != copies.end() && copy->row == row;
    read.place.push_back(is_copy ? read.place[copy->original] : read.distinct.size());
    is_copy ? static_cast<void>(++copy) : read.distinct.push_back(row);
  }
  if (counts.copies == 0) counts.first_copy = describe_copy(copies.front(), table, plot, tree);
  counts.copies += copies.size();
}

std::vector<std::string> RepeatedTreeCounts::notes() const {
  std::vector<std::string> notes = visits.notes();
  if (same > 0) {
    notes.push_back(
        fmt::format("{} skipped, the first: {}",
                    counted(same, "row repeats a tree and is", "rows repeat trees and are"),
                    first_same));
  }
  if (others > 0) {
    notes.push_back(fmt::format(
        "{} the number of another tree of the same plot and got a new one, the first: {}",
        counted(others, "tree has", "trees have"),
        first_other));
  }
  return notes;
}

void keep_one_row_per_tree(data::Table& table,
                           const std::string& plot_column,
                           const std::string& tree_column,
                           const std::optional<std::string>& species_column,
                           const MeasureOf& measure,
                           bool trust_units,
                           RepeatedTreeCounts& counts) {
  const data::TextColumn plot = table.labels(plot_column);
  const data::TextColumn tree = table.labels(tree_column);
  Rows rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!plot.is_missing(row) && !tree.is_missing(row)) rows.push_back(row);
  }
  const stand::Inventory inventory = inventory_of(table, rows, plot, tree, species_column, measure);
  if (!trust_units) stand::check_crowding(inventory, "x, y");
  const auto [repeated, visits, shared_numbers] = stand::repeated_trees(
      inventory, labels_in(stand::usual_time_column(table.names()), table, rows));
  counts.visits.add(visits);
  if (repeated.empty()) return;
  Rows kept;
  data::TextColumn ids;
  auto next = repeated.begin();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool is_first = next == repeated.end() || rows[next->row] != row;
    if (!is_first && !next->later_visit.empty()) {
      ++next;
      continue;
    }
    if (!is_first && next->is_same_tree) {
      const std::size_t line = table.line(rows[next->first_row]);
      const std::string same =
          fmt::format("the same tree is {}{}",
                      line > 0 ? fmt::format("on line {}", line) : "in an earlier row",
                      next->is_later ? ", measured at another time" : "");
      if (counts.same++ == 0) counts.first_same = describe(place_in(table, plot, tree, row), same);
      ++next;
      continue;
    }
    kept.push_back(row);
    if (is_first) {
      tree.is_missing(row) ? ids.append_missing() : ids.append(tree[row]);
      continue;
    }
    if (counts.others++ == 0) {
      counts.first_other = describe(place_in(table, plot, tree, row), "now " + next->new_id);
    }
    ids.append(next++->new_id);
  }
  if (kept.size() < table.rows()) table = table.select(kept);
  table.set(tree_column, std::move(ids));
}

}  // namespace silvafit::study
