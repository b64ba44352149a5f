// SPDX-License-Identifier: MIT
#include "inventory_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::stand {
namespace {

constexpr char kOnlyPlot[] = "1";
constexpr char kOnlySpecies[] = "unknown";

bool is_missing(std::string_view field) {
  return data::is_missing_field(field) || field == "NaN" || field == "nan";
}

}  // namespace

double InventoryReader::number_in(std::string_view field,
                                  const std::string& column,
                                  InventoryRow& row) const {
  const std::string_view text = data::trimmed(field);
  double value = 0.0;
  if (csv_.parse_number(text, value)) return value;
  if (is_missing(text)) return data::kMissing;
  const bool has_comma = text.find(',') != std::string_view::npos;
  const bool has_thousands = has_comma && text.find('.') != std::string_view::npos;
  const char* const advice = has_thousands ? "thousands are written without a separator"
                             : has_comma   ? "decimals need a point"
                                           : "a missing value is an empty field or NA";
  row.unreadable.push_back({.column = column,
                            .value = std::string(text),
                            .reason = fmt::format("'{}' is no number; {}", text, advice)});
  return data::kMissing;
}

void InventoryReader::read_row(const std::vector<std::string_view>& fields,
                               InventoryRow& row,
                               std::size_t position) {
  row.line = csv_.line();
  row.unreadable.clear();
  for (std::size_t i = 0; i < kLabelCount; ++i) {
    const Source& source = plan_.labels[i];
    if (source.field) row.labels[i] = data::trimmed(fields[*source.field]);
  }
  if (plan_.time_field) row.time = data::trimmed(fields[*plan_.time_field]);
  if (plan_.stand_field) row.stand = data::trimmed(fields[*plan_.stand_field]);
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const Source& source = plan_.measures[i];
    row.measures[i] =
        source.field ? number_in(fields[*source.field], source.text, row) : data::kMissing;
  }
  for (std::size_t i = 0; i < plan_.expression_fields.size(); ++i) {
    const ExpressionField& source = plan_.expression_fields[i];
    if (!source.is_text) {
      expression_numbers_[i][position] = number_in(fields[source.field], source.name, row);
    } else if (is_missing(data::trimmed(fields[source.field]))) {
      expression_texts_[i].append_missing();
    } else {
      expression_texts_[i].append(data::trimmed(fields[source.field]));
    }
  }
}

bool InventoryReader::read_block() {
  expression_numbers_.assign(plan_.expression_fields.size(), std::vector<double>(kBlockRows));
  expression_texts_.assign(plan_.expression_fields.size(), {});
  std::vector<std::string_view> fields;
  block_size_ = 0;
  while (block_size_ < kBlockRows && csv_.next(fields)) {
    read_row(fields, block_[block_size_], block_size_);
    ++block_size_;
  }
  evaluate_expressions();
  return block_size_ > 0;
}

void InventoryReader::evaluate_expressions() {
  const auto is_computed = [](const Source& source) { return source.expression.has_value(); };
  if (block_size_ == 0 || std::ranges::none_of(plan_.measures, is_computed)) return;
  data::Table table(block_size_);
  for (std::size_t i = 0; i < plan_.expression_fields.size(); ++i) {
    const ExpressionField& field = plan_.expression_fields[i];
    expression_numbers_[i].resize(block_size_);
    if (field.is_text) {
      table.set(field.name, std::move(expression_texts_[i]));
    } else {
      table.set(field.name, std::move(expression_numbers_[i]));
    }
  }
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    if (!plan_.measures[i].expression) continue;
    const std::vector<double> values = data::evaluate(*plan_.measures[i].expression, table);
    for (std::size_t row = 0; row < block_size_; ++row) block_[row].measures[i] = values[row];
  }
}

/// Fills in what the file leaves out.
void InventoryReader::complete(InventoryRow& row) const {
  if (!plan_.labels[kPlot].exists()) row.labels[kPlot] = kOnlyPlot;
  if (!plan_.labels[kTree].exists()) row.labels[kTree] = fmt::format("{}", row_count_);
  if (!plan_.labels[kSpecies].exists()) row.labels[kSpecies] = kOnlySpecies;
}

void InventoryReader::exclude(const InventoryRow& row,
                              std::string column,
                              std::string value,
                              std::string reason) {
  result_.excluded.push_back({.line = row.line,
                              .plot = row.labels[kPlot],
                              .tree = row.labels[kTree],
                              .column = std::move(column),
                              .value = std::move(value),
                              .reason = std::move(reason)});
}

bool InventoryReader::exclude_if_unlabeled(const InventoryRow& row) {
  bool excluded = false;
  for (const Label label : {kPlot, kTree}) {
    if (!is_missing(row.labels[label])) continue;
    exclude(row,
            plan_.labels[label].text,
            row.labels[label],
            fmt::format("the {} is missing", known_label(label).meaning));
    excluded = true;
  }
  return excluded;
}

void InventoryReader::accept_or_exclude(InventoryRow& row) {
  ++row_count_;
  complete(row);
  bool is_cw_from_radii = false;
  if (std::isnan(row.measures[kCw])) {
    row.measures[kCw] = crown_width_m(row.measures);
    is_cw_from_radii = !std::isnan(row.measures[kCw]);
  }
  bool excluded = exclude_if_unlabeled(row);
  for (ExcludedRow& problem : row.unreadable) {
    exclude(row, std::move(problem.column), std::move(problem.value), std::move(problem.reason));
    excluded = true;
  }
  for (Problem& problem : problems_of(row.measures, options_.needs_coordinates, is_cw_from_radii)) {
    const double value = row.measures[problem.measure];
    const std::string& column = plan_.measures[problem.measure].text;
    // A field that is no number is not missing besides.
    if (std::isnan(value) && !row.unreadable.empty()) continue;
    if (problem.measure == kHcb && value >= row.measures[kH]) ++crown_base_above_top_;
    exclude(row, column, std::isnan(value) ? "" : data::shortest(value), std::move(problem.reason));
    excluded = true;
  }
  if (excluded) {
    ++result_.excluded_tree_count;
    return;
  }
  has_cw_from_radii_ = has_cw_from_radii_ || is_cw_from_radii;
  append(row);
}

void InventoryReader::append(const InventoryRow& row) {
  Inventory& inventory = result_.inventory;
  inventory.lines.push_back(static_cast<std::uint32_t>(row.line));
  kept_rows_.push_back(row_count_ - 1);
  inventory.plot.append(row.labels[kPlot]);
  inventory.tree.append(row.labels[kTree]);
  if (is_missing(row.labels[kSpecies])) {
    inventory.species.append_missing();
  } else {
    inventory.species.append(row.labels[kSpecies]);
  }
  if (plan_.time_field) {
    is_missing(row.time) ? times_.append_missing() : times_.append(row.time);
  }
  if (plan_.stand_field && !is_missing(row.stand)) {
    shared_labels_.add(row.labels[kPlot], row.stand);
  }
  const bool has_radii = std::ranges::all_of(
      kRadii, [this](Measure radius) { return plan_.measures[radius].exists(); });
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const bool is_kept = plan_.measures[i].exists() || (i == kCw && has_radii);
    if (is_kept) values_of(inventory, i).push_back(row.measures[i]);
  }
}

/// Columns that are not ours are read in a pass of their own, since their type is not known before.
void InventoryReader::read_other_columns() {
  Inventory& inventory = result_.inventory;
  inventory.other = data::Table(inventory.size());
  if (plan_.others.empty()) return;
  std::vector<std::string> columns;
  const auto want = [&](const std::string& name) {
    if (std::ranges::find(columns, name) == columns.end()) columns.push_back(name);
  };
  const auto is_column = [this](const std::string& name) {
    return std::ranges::find(csv_.header(), name) != csv_.header().end();
  };
  for (const ColumnMapping& other : plan_.others) {
    if (is_column(other.source)) {
      want(other.source);
      continue;
    }
    for (const std::string& variable : data::Expression::parse(other.source).variables()) {
      data::TextMatch match;
      want(data::is_text_match(variable, match) ? match.column : variable);
    }
  }
  data::CsvTableOptions options{.columns = columns};
  // An expression without columns still needs the rows.
  if (columns.empty()) options.columns = {csv_.header().front()};
  const data::Table source = data::read_csv_table(inventory.file, options).select(kept_rows_);
  for (const ColumnMapping& other : plan_.others) {
    if (!is_column(other.source)) {
      inventory.other.set(other.name,
                          data::evaluate(data::Expression::parse(other.source), source));
    } else if (source.is_numeric(other.source)) {
      const std::span<const double> values = source.numbers(other.source);
      inventory.other.set(other.name, std::vector<double>(values.begin(), values.end()));
    } else {
      inventory.other.set(other.name, source.text(other.source));
    }
  }
}

/// What is counted of the trees that are kept, in the whole file or batch by batch.
void InventoryReader::count_findings() {
  const Inventory& inventory = result_.inventory;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if (inventory.species.is_missing(i)) ++without_species_;
  }
  odd_values_.add(inventory);
}

void InventoryReader::find_plots_left_out() {
  Inventory& inventory = result_.inventory;
  std::unordered_set<std::string_view> seen;
  for (const ExcludedRow& row : result_.excluded) {
    if (is_missing(row.plot) || !seen.insert(row.plot).second) continue;
    if (inventory.plot.code_of(row.plot) != data::TextColumn::kMissingCode) continue;
    inventory.plots_left_out.push_back(row.plot);
  }
}

std::vector<std::string> InventoryReader::notes() const {
  std::vector<std::string> notes = plan_.notes;
  for (std::string& note : repeated_numbers_.notes()) notes.push_back(std::move(note));
  if (!plan_.labels[kPlot].exists()) {
    notes.push_back(
        fmt::format("there is no column plot: all trees are of one plot, '{}'", kOnlyPlot));
  }
  if (!plan_.labels[kTree].exists()) {
    notes.emplace_back("there is no column tree: trees are numbered by row");
  }
  if (!plan_.labels[kSpecies].exists()) {
    notes.push_back(fmt::format("there is no column species: all trees are of one species, '{}'",
                                kOnlySpecies));
  }
  if (plan_.stand_field && plan_.labels[kPlot].exists()) {
    std::string note = shared_labels_.note(csv_.header()[*plan_.stand_field]);
    if (!note.empty()) notes.push_back(std::move(note));
  }
  if (has_cw_from_radii_) {
    notes.emplace_back("cw is taken from the four crown radii where it is not given");
  }
  if (without_species_ > 0)
    notes.push_back(counted(without_species_, "tree has no species", "trees have no species"));
  for (std::string& note : odd_values_.notes()) notes.push_back(std::move(note));
  return notes;
}

void InventoryReader::refuse_empty() const {
  const std::string& file = result_.inventory.file;
  if (row_count_ == 0) throw InputError("there is a header but no tree", {.file = file});
  throw InputError("no row can be used: " + describe_excluded(result_), {.file = file});
}

CheckedInventory InventoryReader::read() {
  while (read_block()) {
    for (std::size_t i = 0; i < block_size_; ++i) accept_or_exclude(block_[i]);
  }
  resolve_repeated_trees(plan_.labels[kTree].text, times_, result_, kept_rows_, repeated_numbers_);
  if (!options_.trust_units) check_units(result_.inventory, plan_, crown_base_above_top_);
  if (result_.inventory.size() == 0) refuse_empty();
  find_plots_left_out();
  read_other_columns();
  count_findings();
  result_.notes = notes();
  return std::move(result_);
}

CheckedInventory read_inventory(const std::filesystem::path& path,
                                const InventoryOptions& options) {
  return InventoryReader(path, options).read();
}

}  // namespace silvafit::stand
