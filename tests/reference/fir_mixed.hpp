// SPDX-License-Identifier: MIT
// The simulated inventory of the reference numbers, with its indices, as one table.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "expected.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::test {

/// Trees of a species whose indices are not disturbed by the edge, ordered by number.
/// \param core  the column that says so: in_core or in_core_plot
inline data::Table fir_mixed(const std::string& species, const std::string& core = "in_core") {
  data::Table trees = data::read_csv_table(reference_data("fir_mixed/inventory.csv"));
  const data::Table indices = data::read_csv_table(reference_data("fir_mixed/indices.csv"));
  std::map<double, std::size_t> row_of;
  for (std::size_t row = 0; row < indices.rows(); ++row) {
    row_of[indices.numbers("tree")[row]] = row;
  }
  for (const char* name : {"W", "M", "U", "C", "in_core", "in_core_plot"}) {
    std::vector<double> values;
    for (const double tree : trees.numbers("tree")) {
      values.push_back(indices.numbers(name)[row_of.at(tree)]);
    }
    trees.set(name, values);
  }
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < trees.rows(); ++row) {
    if (trees.numbers(core)[row] == 1.0 && trees.text("species")[row] == species) {
      rows.push_back(row);
    }
  }
  std::ranges::sort(rows, {}, [&](std::size_t row) { return trees.numbers("tree")[row]; });
  return trees.select(rows);
}

}  // namespace silvafit::test
