// SPDX-License-Identifier: MIT
// Public data sets of the reference numbers as tables.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::test {

/// A public data set, its rows numbered as in the reference, with the rows that it used.
inline data::Table public_table(const std::string& name) {
  data::Table table = data::read_csv_table(reference_data(name + ".csv"));
  std::vector<double> numbers(table.rows());
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    numbers[row] = static_cast<double>(row + 1);
    const auto value = [&](const char* column) { return table.numbers(column)[row]; };
    const bool used = name == "spati"     ? value("pl") == 1.0 && value("d") > 0.0
                      : name == "alsTree" ? !std::isnan(value("HCB") + value("H") + value("DBH"))
                                          : true;
    if (used) rows.push_back(row);
  }
  table.set("number", numbers);
  return table.select(rows);
}

}  // namespace silvafit::test
