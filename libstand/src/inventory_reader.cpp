// SPDX-License-Identifier: MIT
// Reads an inventory in blocks of rows: fields to numbers, expressions to measures, measures
// through the checks, and what passes them into columns.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "inventory_checks.hpp"
#include "inventory_columns.hpp"
#include "inventory_repeats.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {
namespace {

constexpr std::size_t kBlockRows = 4096;
constexpr char kOnlyPlot[] = "1";
constexpr char kOnlySpecies[] = "unknown";

bool is_missing(std::string_view field) {
  return data::is_missing_field(field) || field == "NaN" || field == "nan";
}

/// A row of the current block.
struct Row {
  std::size_t line = 0;
  std::array<std::string, kLabelCount> labels{};
  Measures measures{};
  std::vector<ExcludedRow> unreadable{};  ///< fields that should be numbers and are none
};

class Reader {
 public:
  Reader(const std::filesystem::path& path, InventoryOptions options)
      : csv_(path),
        options_(std::move(options)),
        plan_(plan_columns(csv_.header(), options_, path.string())) {
    result_.inventory.file = path.string();
    result_.notes = plan_.notes;
  }

  CheckedInventory read();
  std::optional<CheckedInventory> read_batch(std::size_t trees);
  bool wants_other_columns() const { return !plan_.others.empty(); }

 private:
  bool fill_batch(std::size_t trees);
  bool is_new_plot(const Row& row) const;
  void finish_plots();
  void check_not_finished(const Row& row) const;
  bool read_block();
  void read_row(const std::vector<std::string_view>& fields, Row& row, std::size_t position);
  double number_in(std::string_view field, const std::string& column, Row& row) const;
  void evaluate_expressions();
  void accept_or_exclude(Row& row);
  void complete(Row& row) const;
  bool exclude_if_unlabelled(const Row& row);
  void append(const Row& row);
  void exclude(const Row& row, std::string column, std::string value, std::string reason);
  void resolve_repeated_trees();
  void exclude_same_tree(const RepeatedTree& tree);
  void keep_rows(const std::vector<std::size_t>& rows);
  void read_other_columns();
  void add_notes();
  [[noreturn]] void refuse_empty() const;

  data::CsvReader csv_;
  InventoryOptions options_;
  ColumnPlan plan_;
  CheckedInventory result_{};
  std::vector<Row> block_ = std::vector<Row>(kBlockRows);
  std::size_t block_size_ = 0;
  std::size_t next_in_block_ = 0;               ///< first row of the block not yet taken
  std::unordered_set<std::string> finished_{};  ///< plots of earlier batches
  bool is_first_batch_ = true;
  std::vector<std::vector<double>> expression_numbers_{};
  std::vector<data::TextColumn> expression_texts_{};
  std::size_t row_count_ = 0;
  std::vector<std::size_t> kept_rows_{};  ///< position in the file of each tree, from 0
  std::size_t crown_base_above_top_ = 0;
  bool has_cw_from_radii_ = false;
};

double Reader::number_in(std::string_view field, const std::string& column, Row& row) const {
  const std::string_view text = data::trimmed(field);
  double value = 0.0;
  if (data::parse_number(text, value)) return value;
  if (is_missing(text)) return data::kMissing;
  const bool has_decimal_comma = text.find(',') != std::string_view::npos;
  row.unreadable.push_back(
      {.column = column,
       .value = std::string(text),
       .reason = fmt::format(
           "'{}' is no number{}", text, has_decimal_comma ? "; decimals need a point" : "")});
  return data::kMissing;
}

void Reader::read_row(const std::vector<std::string_view>& fields, Row& row, std::size_t position) {
  row.line = csv_.line();
  row.unreadable.clear();
  for (std::size_t i = 0; i < kLabelCount; ++i) {
    const Source& source = plan_.labels[i];
    if (source.field) row.labels[i] = data::trimmed(fields[*source.field]);
  }
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

bool Reader::read_block() {
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

void Reader::evaluate_expressions() {
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
void Reader::complete(Row& row) const {
  if (!plan_.labels[kPlot].exists()) row.labels[kPlot] = kOnlyPlot;
  if (!plan_.labels[kTree].exists()) row.labels[kTree] = fmt::format("{}", row_count_);
  if (!plan_.labels[kSpecies].exists()) row.labels[kSpecies] = kOnlySpecies;
}

void Reader::exclude(const Row& row, std::string column, std::string value, std::string reason) {
  result_.excluded.push_back({.line = row.line,
                              .plot = row.labels[kPlot],
                              .tree = row.labels[kTree],
                              .column = std::move(column),
                              .value = std::move(value),
                              .reason = std::move(reason)});
}

bool Reader::exclude_if_unlabelled(const Row& row) {
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

void Reader::accept_or_exclude(Row& row) {
  ++row_count_;
  complete(row);
  bool is_cw_from_radii = false;
  if (std::isnan(row.measures[kCw])) {
    row.measures[kCw] = crown_width_m(row.measures);
    is_cw_from_radii = !std::isnan(row.measures[kCw]);
  }
  bool excluded = exclude_if_unlabelled(row);
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

void Reader::append(const Row& row) {
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
  const bool has_radii = std::ranges::all_of(
      kRadii, [this](Measure radius) { return plan_.measures[radius].exists(); });
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const bool is_kept = plan_.measures[i].exists() || (i == kCw && has_radii);
    if (is_kept) values_of(inventory, i).push_back(row.measures[i]);
  }
}

void Reader::resolve_repeated_trees() {
  Inventory& inventory = result_.inventory;
  const std::vector<RepeatedTree> repeated = repeated_trees(inventory);
  if (repeated.empty()) return;
  std::vector<std::size_t> kept;
  data::TextColumn ids;
  std::size_t renamed = 0;
  std::string first_renamed;
  auto next = repeated.begin();
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const bool is_repeated = next != repeated.end() && next->row == row;
    if (is_repeated && next->is_same_tree) {
      exclude_same_tree(*next++);
      continue;
    }
    kept.push_back(row);
    ids.append(is_repeated ? std::string_view(next->new_id) : inventory.tree[row]);
    if (!is_repeated) continue;
    if (renamed++ == 0) first_renamed = describe(inventory.place(row), "now " + next->new_id);
    ++next;
  }
  keep_rows(kept);
  inventory.tree = std::move(ids);
  std::ranges::stable_sort(result_.excluded, {}, &ExcludedRow::line);
  if (renamed > 0) {
    result_.notes.push_back(fmt::format(
        "{} trees have the number of another tree of their plot and got one of their own, the "
        "first: {}",
        renamed,
        first_renamed));
  }
}

void Reader::exclude_same_tree(const RepeatedTree& tree) {
  const Inventory& inventory = result_.inventory;
  ++result_.excluded_tree_count;
  result_.excluded.push_back(
      {.line = inventory.lines[tree.row],
       .plot = std::string(inventory.plot[tree.row]),
       .tree = std::string(inventory.tree[tree.row]),
       .column = plan_.labels[kTree].text,
       .value = std::string(inventory.tree[tree.row]),
       .reason = fmt::format("the same tree is on line {}", inventory.lines[tree.first_row])});
}

void Reader::keep_rows(const std::vector<std::size_t>& rows) {
  Inventory& inventory = result_.inventory;
  if (rows.size() == inventory.size()) return;
  const auto select = [&rows](auto& values) {
    if (values.empty()) return;
    for (std::size_t i = 0; i < rows.size(); ++i) values[i] = values[rows[i]];
    values.resize(rows.size());
  };
  const auto select_text = [&rows](data::TextColumn& column) {
    data::TextColumn kept;
    kept.reserve(rows.size());
    for (const std::size_t row : rows) {
      column.is_missing(row) ? kept.append_missing() : kept.append(column[row]);
    }
    column = std::move(kept);
  };
  for (std::size_t i = 0; i < kMeasureCount; ++i) select(values_of(inventory, i));
  select(inventory.lines);
  select(kept_rows_);
  select_text(inventory.plot);
  select_text(inventory.tree);
  select_text(inventory.species);
}

/// Columns that are not ours are read in a pass of their own, since their type is not known before.
void Reader::read_other_columns() {
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

void Reader::add_notes() {
  std::vector<std::string>& notes = result_.notes;
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
  if (has_cw_from_radii_) {
    notes.emplace_back("cw is taken from the four crown radii where it is not given");
  }
  const Inventory& inventory = result_.inventory;
  std::size_t without_species = 0;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if (inventory.species.is_missing(i)) ++without_species;
  }
  if (without_species > 0)
    notes.push_back(fmt::format("{} trees have no species", without_species));
  for (std::string& note : notes_on_odd_values(inventory)) notes.push_back(std::move(note));
}

void Reader::refuse_empty() const {
  const std::string& file = result_.inventory.file;
  if (row_count_ == 0) throw InputError("there is a header but no tree", {.file = file});
  throw InputError("no row can be used: " + describe_excluded(result_), {.file = file});
}

/// Whether a row begins another plot than the last tree's.
bool Reader::is_new_plot(const Row& row) const {
  const data::TextColumn& plots = result_.inventory.plot;
  return plan_.labels[kPlot].exists() && plots[plots.size() - 1] != row.labels[kPlot];
}

/// Takes rows until the batch is full and its last plot whole; false at the end of the file.
bool Reader::fill_batch(std::size_t trees) {
  for (;;) {
    for (; next_in_block_ < block_size_; ++next_in_block_) {
      Row& row = block_[next_in_block_];
      if (result_.inventory.size() >= trees && is_new_plot(row)) return true;
      check_not_finished(row);
      accept_or_exclude(row);
    }
    if (!read_block()) return false;
    next_in_block_ = 0;
  }
}

void Reader::check_not_finished(const Row& row) const {
  if (finished_.empty() || !finished_.contains(row.labels[kPlot])) return;
  throw InputError("the plot comes again after others; to read plot by plot, sort the file by plot",
                   {.file = result_.inventory.file, .line = row.line, .plot = row.labels[kPlot]});
}

void Reader::finish_plots() {
  for (const std::string& plot : result_.inventory.plot.levels()) finished_.insert(plot);
}

std::optional<CheckedInventory> Reader::read_batch(std::size_t trees) {
  fill_batch(trees);
  const bool is_empty = result_.inventory.size() == 0;
  if (is_empty && is_first_batch_) refuse_empty();
  if (is_empty && result_.excluded.empty()) return std::nullopt;
  finish_plots();
  resolve_repeated_trees();
  if (is_first_batch_ && !options_.trust_units) {
    check_units(result_.inventory, plan_, crown_base_above_top_);
  }
  add_notes();
  CheckedInventory batch = std::move(result_);
  result_ = {};
  result_.inventory.file = batch.inventory.file;
  kept_rows_.clear();
  has_cw_from_radii_ = false;
  is_first_batch_ = false;
  return batch;
}

CheckedInventory Reader::read() {
  while (read_block()) {
    for (std::size_t i = 0; i < block_size_; ++i) accept_or_exclude(block_[i]);
  }
  resolve_repeated_trees();
  if (!options_.trust_units) check_units(result_.inventory, plan_, crown_base_above_top_);
  if (result_.inventory.size() == 0) refuse_empty();
  read_other_columns();
  add_notes();
  return std::move(result_);
}

}  // namespace

CheckedInventory read_inventory(const std::filesystem::path& path,
                                const InventoryOptions& options) {
  return Reader(path, options).read();
}

struct InventoryBatches::State {
  Reader reader;
  std::size_t trees;
};

InventoryBatches::InventoryBatches(const std::filesystem::path& path,
                                   const InventoryOptions& options,
                                   std::size_t trees)
    : state_(std::make_unique<State>(State{Reader(path, options), trees})) {
  if (state_->reader.wants_other_columns()) {
    throw UsageError("columns beyond the inventory's own cannot be read plot by plot",
                     {.file = path.string()});
  }
}

InventoryBatches::~InventoryBatches() = default;
InventoryBatches::InventoryBatches(InventoryBatches&&) noexcept = default;
InventoryBatches& InventoryBatches::operator=(InventoryBatches&&) noexcept = default;

std::optional<CheckedInventory> InventoryBatches::next() {
  return state_->reader.read_batch(state_->trees);
}

}  // namespace silvafit::stand
