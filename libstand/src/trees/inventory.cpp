// SPDX-License-Identifier: MIT
// A checked inventory as a table, and the list of its skipped rows.
#include "silvafit/stand/inventory.hpp"

#include <fmt/format.h>

#include <ostream>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/csv.hpp"
#include "trees/inventory_columns.hpp"

namespace silvafit::stand {

std::string label_of(const TreeQuantity& quantity) {
  return quantity.unit.empty() ? quantity.name : quantity.name + "_" + quantity.unit;
}

Place Inventory::place(std::size_t row) const {
  Place place{.file = file, .plot = std::string(plot[row]), .tree = std::string(tree[row])};
  if (row < lines.size()) place.line = lines[row];
  return place;
}

void ExcludedSummary::add(const CheckedInventory& batch) {
  left_out_ += batch.excluded_tree_count;
  kept_ += batch.inventory.size();
  for (const ExcludedRow& row : batch.excluded) {
    if (!row.is_problem) {
      ++without_problem_;
      continue;
    }
    if (problems_++ < most_shown_) shown_.push_back(row);
  }
}

std::string ExcludedSummary::text(const std::string& file) const {
  if (problems_ == 0) return {};
  std::string text = fmt::format("{} of {} rows skipped, {}",
                                 left_out_ - without_problem_,
                                 left_out_ + kept_,
                                 counted(problems_, "problem", "problems"));
  for (const ExcludedRow& row : shown_) {
    const Place place{
        .file = file, .line = row.line, .column = row.column, .plot = row.plot, .tree = row.tree};
    text += "\n  " + describe(place, row.reason);
  }
  if (problems_ > shown_.size()) text += fmt::format("\n  and {} more", problems_ - shown_.size());
  return text;
}

void write_excluded(const std::vector<ExcludedRow>& excluded, std::ostream& stream) {
  stream << kExcludedHeader;
  for (const ExcludedRow& row : excluded) stream << csv_text(row);
}

std::string csv_text(const ExcludedRow& row) {
  std::string text = std::to_string(row.line);
  for (const std::string* field : {&row.plot, &row.tree, &row.column, &row.value, &row.reason}) {
    text += ',' + data::csv_field(*field);
  }
  return text + '\n';
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
    data::copy_column(name, inventory.other, name, table);
  }
  table.set_origin(inventory.file, inventory.lines);
  return table;
}

}  // namespace silvafit::stand
