// SPDX-License-Identifier: MIT
// Rows of a table that have the plot and tree of an earlier row.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/tree_table.hpp"

namespace silvafit::study {

/// Finds the rows that have the plot and tree of an earlier row. A copy has its values in all
/// columns. Other rows are further observations of a tree, or another tree of the same number.
/// \param read    gets the distinct rows, if there are copies
/// \param counts  of earlier parts; those of this table are added
void find_copies(const std::string& plot_column,
                 const std::string& tree_column,
                 ObservedTable& read,
                 RepeatCounts& counts);

/// The values of all rows from those of the distinct ones.
/// \param place  as ObservedTable::place, not empty
template <class Value>
std::vector<Value> of_all_rows(const std::vector<Value>& values,
                               const std::vector<std::size_t>& place) {
  std::vector<Value> all;
  all.reserve(place.size());
  for (const std::size_t row : place) all.push_back(values[row]);
  return all;
}

/// The numbers of a measure (x, dbh ...), NaN where unknown; empty if the table has no such column.
using MeasureOf = std::function<std::vector<double>(const std::string& name)>;

/// Keeps one row for each tree at one time, by the rule for inventories
/// (stand::repeated_trees()): earlier visits of a plot and copies are removed, other trees of the
/// same number get a new one.
/// \param trust_units  positions are not checked (stand::check_crowding())
/// \param counts       of earlier parts; those of this table are added
void keep_one_row_per_tree(data::Table& table,
                           const std::string& plot_column,
                           const std::string& tree_column,
                           const std::optional<std::string>& species_column,
                           const MeasureOf& measure,
                           bool trust_units,
                           RepeatedTreeCounts& counts);

}  // namespace silvafit::study
