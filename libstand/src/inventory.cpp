// SPDX-License-Identifier: MIT
// What is done with a checked inventory: as a table, and what was left out of it.
#include "silvafit/stand/inventory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "inventory_columns.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::stand {

Place Inventory::place(std::size_t row) const {
  Place place{.file = file, .plot = std::string(plot[row]), .tree = std::string(tree[row])};
  if (row < lines.size()) place.line = lines[row];
  return place;
}

std::string describe_excluded(const CheckedInventory& checked, std::size_t most_shown) {
  return describe_excluded(checked.excluded,
                           checked.excluded_tree_count,
                           checked.inventory.size(),
                           checked.inventory.file,
                           most_shown);
}

std::string describe_excluded(const std::vector<ExcludedRow>& excluded,
                              std::size_t left_out,
                              std::size_t kept,
                              const std::string& file,
                              std::size_t most_shown) {
  std::vector<const ExcludedRow*> problems;
  for (const ExcludedRow& row : excluded) {
    if (row.is_problem) problems.push_back(&row);
  }
  if (problems.empty()) return {};
  const std::size_t without_problem = excluded.size() - problems.size();
  std::string text = fmt::format("{} of {} rows skipped, {}",
                                 left_out - without_problem,
                                 left_out + kept,
                                 counted(problems.size(), "problem", "problems"));
  for (std::size_t i = 0; i < std::min(most_shown, problems.size()); ++i) {
    const ExcludedRow& row = *problems[i];
    const Place place{
        .file = file, .line = row.line, .column = row.column, .plot = row.plot, .tree = row.tree};
    text += "\n  " + describe(place, row.reason);
  }
  if (problems.size() > most_shown) {
    text += fmt::format("\n  and {} more", problems.size() - most_shown);
  }
  return text;
}

void write_excluded(const std::vector<ExcludedRow>& excluded, std::ostream& stream) {
  stream << "line,plot,tree,column,value,reason\n";
  for (const ExcludedRow& row : excluded) {
    stream << row.line;
    for (const std::string* field : {&row.plot, &row.tree, &row.column, &row.value, &row.reason}) {
      stream << ',' << data::csv_field(*field);
    }
    stream << '\n';
  }
}

void write_excluded(const std::vector<ExcludedRow>& excluded, const std::filesystem::path& path) {
  AtomicFile file(path);
  write_excluded(excluded, file.stream());
  file.commit();
}

data::Table to_table(const Inventory& inventory) {
  data::Table table(inventory.size());
  table.set(known_label(kPlot).name, inventory.plot);
  table.set(known_label(kTree).name, inventory.tree);
  table.set(known_label(kSpecies).name, inventory.species);
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const std::vector<double>& values = values_of(inventory, i);
    if (!values.empty()) table.set(known_measure(i).name, values);
  }
  for (const std::string& name : inventory.other.names()) {
    if (inventory.other.is_numeric(name)) {
      const std::span<const double> values = inventory.other.numbers(name);
      table.set(name, std::vector<double>(values.begin(), values.end()));
    } else {
      table.set(name, inventory.other.text(name));
    }
  }
  table.set_origin(inventory.file, inventory.lines);
  return table;
}

}  // namespace silvafit::stand
