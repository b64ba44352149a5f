// SPDX-License-Identifier: MIT
// Reads the columns of an inventory besides its own. Their type is known only from the whole file.
#include <algorithm>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"
#include "trees/inventory_reader.hpp"

namespace silvafit::stand {

/// Columns of the file that other columns are or are computed from.
std::vector<std::string> InventoryReader::sources_of_others() const {
  std::vector<std::string> columns;
  const auto want = [&](const std::string& name) {
    if (std::ranges::find(columns, name) == columns.end()) columns.push_back(name);
  };
  for (const ColumnMapping& other : plan_.others) {
    if (std::ranges::find(csv_.header(), other.source) != csv_.header().end()) {
      want(other.source);
      continue;
    }
    for (const std::string& variable : data::Expression::parse(other.source).variables()) {
      data::TextMatch match;
      want(data::is_text_match(variable, match) ? match.column : variable);
    }
  }
  // An expression without columns still needs the rows.
  if (columns.empty()) columns.push_back(csv_.header().front());
  return columns;
}

/// In a separate pass over the table or part.
void InventoryReader::read_other_columns() {
  data::Table& table = result_.inventory.other;
  table = data::Table(result_.inventory.size());
  if (plan_.others.empty()) return;
  const data::CsvTableOptions options{
      .columns = sources_of_others(), .missing = options_.missing, .fill_down = plan_.filled_down};
  const data::Table source = data::read_csv_table(prepared_.table, options).select(kept_rows_);
  for (const ColumnMapping& other : plan_.others) {
    if (std::ranges::find(csv_.header(), other.source) == csv_.header().end()) {
      table.set(other.name, data::evaluate(data::Expression::parse(other.source), source));
    } else {
      data::copy_column(other.name, source, other.source, table);
    }
  }
}

}  // namespace silvafit::stand
