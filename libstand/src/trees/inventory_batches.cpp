// SPDX-License-Identifier: MIT
// The parts of an inventory: the whole table, whole plots for files larger than memory, or rows.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/read_ahead.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/program.hpp"
#include "trees/inventory_reader.hpp"

namespace silvafit::stand {

/// Rows are sorted by plot, on disk, if those of a plot do not follow each other. A pipe is read
/// once, and without a column of tree numbers, trees are numbered in the order of the rows.
std::optional<data::TableParts> InventoryReader::parts(std::size_t rows) {
  if (of_ == BatchOf::kTable) return std::nullopt;
  const Source& plot = plan_.labels[kPlot];
  std::error_code ignored;
  const bool is_file = std::filesystem::is_regular_file(file_, ignored);
  const bool has_condition = !options_.where.empty();
  const bool is_of_rows = of_ == BatchOf::kRows;
  data::TablePartsOptions wanted{
      .missing = options_.missing,
      .fill_down = plan_.filled_down,
      .finds_kinds = is_of_rows || !plan_.others.empty() || has_condition,
      .rows = rows};
  if (wanted.finds_kinds && !is_file) {
    throw UsageError(
        is_of_rows
            ? "a pipe cannot be read twice; give a file"
            : "columns beyond the inventory's own, and `where`, need a file that can be read twice",
        {.file = file_});
  }
  // Without a column of plots, all trees are of one.
  if (!is_of_rows && !plot.exists()) {
    if (has_condition) prepared_ = prepared_table(csv_.source(), options_);
    if (has_condition) csv_ = data::CsvReader(prepared_.table, options_.missing);
    return std::nullopt;
  }
  if (has_condition)
    prepared_.note = "rows are chosen, by the condition " + options_.where +
                     ", and plots without such a row do not count; `by` keeps them";
  if (!is_of_rows) {
    wanted.group = plot.joined;
    if (plot.field) wanted.group.push_back(*plot.field);
    if (!is_file || !has_tree_numbers()) {
      wanted.refuse_group = [file = file_, has_stands = !plan_.unit_fields.empty()](
                                std::size_t line, const std::string& label) {
        throw InputError(
            fmt::format("the plot comes again after others; to read plot by plot, sort the file by "
                        "plot{}",
                        has_stands ? " or, if it is another plot in another stand, give plots "
                                     "labels that are unique in the file"
                                   : ""),
            {.file = file, .line = line, .plot = label});
      };
    }
  }
  if (is_file) return data::TableParts(file_, wanted);
  return data::TableParts(std::move(csv_), wanted);
}

void InventoryReader::open(const std::shared_ptr<const data::TableText>& part) {
  prepared_.table = prepared_table(part, options_, true).table;
  csv_ = data::CsvReader(prepared_.table, options_.missing);
}

struct InventoryBatches::State {
  State(InventoryReader opened,
        std::size_t rows_of_batch,
        unsigned threads,
        std::function<void(const std::string&)> note_callback)
      : reader(std::move(opened)),
        parts(reader.parts(rows_of_batch)),
        note(std::move(note_callback)),
        ahead([this] { return read(); }, threads) {}

  std::optional<CheckedInventory> read();
  void give(const std::vector<std::string>& texts) const {
    for (const std::string& text : texts) {
      if (note && !text.empty()) note(text);
    }
  }

  InventoryReader reader;
  std::optional<data::TableParts> parts;  ///< none if the table is read as one part
  std::function<void(const std::string&)> note;
  std::shared_ptr<const data::TableText> rows{};
  bool is_read = false;
  bool is_noted = false;
  std::vector<std::string> on_table{};  ///< notes on a whole table
  ReadAhead<std::optional<CheckedInventory>> ahead;
};

InventoryBatches::InventoryBatches(const data::TableSource& source,
                                   const InventoryOptions& options,
                                   std::size_t rows,
                                   BatchOf of,
                                   unsigned threads,
                                   std::function<void(const std::string&)> note) {
  const bool is_file = std::holds_alternative<std::filesystem::path>(source);
  if (of != BatchOf::kTable && !is_file) {
    throw UsageError("only CSV files can be read plot by plot", {.column = "`stream`"});
  }
  state_ = std::make_unique<State>(InventoryReader(source, options, of),
                                   rows,
                                   of == BatchOf::kTable ? 1 : threads,
                                   std::move(note));
  if (is_sorted()) state_->give({kSortedNote});
}

InventoryBatches::~InventoryBatches() = default;
InventoryBatches::InventoryBatches(InventoryBatches&&) noexcept = default;
InventoryBatches& InventoryBatches::operator=(InventoryBatches&&) noexcept = default;

std::optional<CheckedInventory> InventoryBatches::State::read() {
  while (!is_read) {
    if (parts) {
      rows = parts->next();
      if (!rows) break;
      reader.open(rows);
    } else {
      is_read = true;
    }
    CheckedInventory batch = reader.read();
    batch.is_in_file_order = !parts || !parts->is_sorted();
    if (batch.inventory.size() > 0 || !batch.excluded.empty()) return batch;
  }
  if (!std::exchange(is_read, true)) reader.require_trees();
  return std::nullopt;
}

std::optional<CheckedInventory> InventoryBatches::next() {
  std::optional<CheckedInventory> batch = state_->ahead.next();
  const bool is_complete = !batch || state_->reader.is_of_table();
  if (!is_complete || std::exchange(state_->is_noted, true)) return batch;
  if (batch) state_->on_table = batch->notes;
  const std::vector<std::string> all = notes();
  state_->give({all.begin() + (is_sorted() ? 1 : 0), all.end()});
  state_->give({excluded()});
  return batch;
}

const std::shared_ptr<const data::TableText>& InventoryBatches::rows() const {
  return state_->rows;
}

std::size_t InventoryBatches::row_count() const {
  return state_->parts ? state_->parts->rows() : 0;
}

std::vector<std::string> InventoryBatches::notes() const {
  std::vector<std::string> notes =
      state_->on_table.empty() ? state_->reader.notes() : state_->on_table;
  if (is_sorted()) notes.insert(notes.begin(), kSortedNote);
  return notes;
}

std::vector<std::string> InventoryBatches::recognized() const {
  return state_->reader.recognized();
}

bool InventoryBatches::is_sorted() const { return state_->parts && state_->parts->is_sorted(); }

bool InventoryBatches::has_numbers() const { return state_->reader.has_tree_numbers(); }

std::string InventoryBatches::excluded() const { return state_->reader.excluded(); }

CheckedInventory read_inventory(const data::TableSource& source, const InventoryOptions& options) {
  return InventoryReader(source, options, BatchOf::kTable).read();
}

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
    for (const std::string& column : data::columns_of(data::Expression::parse(other.source))) {
      want(column);
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
  data::Table source = data::read_csv_table(prepared_.table, options).select(kept_rows_);
  data::take_missing_codes(source, codes_);
  for (const ColumnMapping& other : plan_.others) {
    if (std::ranges::find(csv_.header(), other.source) == csv_.header().end()) {
      table.set(other.name, data::evaluate(data::Expression::parse(other.source), source));
    } else {
      data::copy_column(other.name, source, other.source, table);
    }
  }
}

}  // namespace silvafit::stand
