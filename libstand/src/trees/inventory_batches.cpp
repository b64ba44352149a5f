// SPDX-License-Identifier: MIT
// Reads an inventory plot by plot, for files larger than memory.
#include <memory>
#include <utility>

#include "silvafit/base/error.hpp"
#include "trees/inventory_reader.hpp"

namespace silvafit::stand {

/// Whether a row begins another plot than the last tree's.
bool InventoryReader::is_new_plot(const InventoryRow& row) const {
  const data::TextColumn& plots = result_.inventory.plot;
  if (plots.size() == 0) return true;
  return plan_.labels[kPlot].exists() && plots[plots.size() - 1] != row.labels[kPlot];
}

/// Reads rows until the batch is full (trees or skipped rows) and its last plot is complete; false
/// at the end of the file.
bool InventoryReader::fill_batch(std::size_t trees, bool of_whole_plots) {
  // A problem with its texts needs as much memory as this many trees with their structural units.
  constexpr std::size_t kRowsForProblem = 10;
  for (;;) {
    for (; next_in_block_ < block_size_; ++next_in_block_) {
      InventoryRow& row = block_[next_in_block_];
      const bool is_full =
          result_.inventory.size() >= trees || kRowsForProblem * result_.excluded.size() >= trees;
      if (is_full && (!of_whole_plots || is_new_plot(row))) return true;
      if (of_whole_plots) check_not_finished(row);
      accept_or_exclude(row);
    }
    if (!read_block()) return false;
    next_in_block_ = 0;
  }
}

void InventoryReader::check_not_finished(const InventoryRow& row) const {
  if (!is_new_plot(row) || !finished_.contains(row.labels[kPlot])) return;
  std::string what =
      "the plot comes again after others; to read plot by plot, sort the file by plot";
  if (plan_.stand_field) {
    what +=
        " or, if it is another plot in another stand, give plots labels that are unique in the "
        "file";
  }
  throw InputError(what,
                   {.file = result_.inventory.file, .line = row.line, .plot = row.labels[kPlot]});
}

void InventoryReader::prepare_batches() {
  const auto* const path = std::get_if<std::filesystem::path>(&prepared_.table);
  std::error_code ignored;
  const bool is_file = path != nullptr && std::filesystem::is_regular_file(*path, ignored);
  const bool has_others = !plan_.others.empty();
  const bool has_condition = !options_.where.empty();
  if ((has_others || has_condition) && !is_file) {
    throw UsageError(
        "columns beyond the inventory's own, and `where`, need a file that can be read twice",
        {.file = csv_.file()});
  }
  // Without a column of tree numbers, trees are numbered in the order of the rows.
  const bool can_sort = is_file && plan_.labels[kPlot].field && plan_.labels[kTree].exists();
  if (!can_sort && !has_others && !has_condition) return;
  data::TableParts parts(*path,
                         {.group = can_sort ? plan_.labels[kPlot].field : std::nullopt,
                          .missing = options_.missing,
                          .fill_down = plan_.filled_down,
                          .finds_kinds = has_others || has_condition});
  if (!parts.is_sorted() && !has_others && !has_condition) return;
  parts_.emplace(std::move(parts));
  open_next_part();
  if (has_condition) prepared_.note = "rows are chosen, by the condition " + options_.where;
  find_fields_of_others();
}

void InventoryReader::finish_plots() {
  finished_.add(result_.inventory.plot.levels());
  shared_labels_.finish_plots();
}

std::optional<CheckedInventory> InventoryReader::read_batch(std::size_t trees) {
  const bool is_more = fill_batch(trees, true);
  const bool is_empty = result_.inventory.size() == 0;
  if (is_empty && is_first_batch_ && !is_more) {
    excluded_.add(result_);
    refuse_empty(excluded());
  }
  if (is_empty && result_.excluded.empty()) return std::nullopt;
  finish_plots();
  resolve_repeated_trees(plan_.labels[kTree].text, times_, result_, kept_rows_, repeated_numbers_);
  if (!options_.case_sensitive) spellings_.unify(result_.inventory.species);
  return hand_over_batch();
}

std::optional<CheckedInventory> InventoryReader::read_rows(std::size_t trees) {
  fill_batch(trees, false);
  const bool is_empty = result_.inventory.size() == 0;
  if (is_empty && result_.excluded.empty()) {
    if (is_first_batch_) refuse_empty(excluded());
    return std::nullopt;
  }
  return hand_over_batch();
}

/// The batch, checked and counted; the reader is ready for the next one.
CheckedInventory InventoryReader::hand_over_batch() {
  const bool is_empty = result_.inventory.size() == 0;
  if (is_first_batch_ && !is_empty && !options_.trust_units) {
    check_units(result_.inventory, plan_, crown_base_above_top_);
  }
  find_plots_left_out();
  read_others_of_batch();
  count_findings();
  excluded_.add(result_);
  result_.is_in_file_order = !is_sorted();
  CheckedInventory batch = std::move(result_);
  result_ = {};
  result_.inventory.file = batch.inventory.file;
  result_.inventory.expansion = batch.inventory.expansion;
  kept_rows_.clear();
  times_ = {};
  is_first_batch_ = is_first_batch_ && is_empty;
  return batch;
}

struct InventoryBatches::State {
  InventoryReader reader;
  std::size_t trees;
};

InventoryBatches::InventoryBatches(const std::filesystem::path& path,
                                   const InventoryOptions& options,
                                   std::size_t trees)
    : state_(std::make_unique<State>(State{InventoryReader(path, options, true), trees})) {
  state_->reader.prepare_batches();
}

InventoryBatches::~InventoryBatches() = default;
InventoryBatches::InventoryBatches(InventoryBatches&&) noexcept = default;
InventoryBatches& InventoryBatches::operator=(InventoryBatches&&) noexcept = default;

std::optional<CheckedInventory> InventoryBatches::next() {
  return state_->reader.read_batch(state_->trees);
}

std::vector<std::string> InventoryBatches::notes() const { return state_->reader.notes(); }

std::vector<std::string> InventoryBatches::recognized() const {
  return state_->reader.recognized();
}

bool InventoryBatches::is_sorted() const { return state_->reader.is_sorted(); }

std::string InventoryBatches::excluded() const { return state_->reader.excluded(); }

}  // namespace silvafit::stand
