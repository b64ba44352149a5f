// SPDX-License-Identifier: MIT
// The parts of an inventory: the whole table, whole plots for files larger than memory, or rows.
#include <memory>
#include <utility>

#include "silvafit/base/error.hpp"
#include "trees/inventory_reader.hpp"

namespace silvafit::stand {

struct InventoryBatches::State {
  InventoryReader reader;
  BatchOf of;
  std::optional<data::TableParts> parts;  ///< none if the table is read as one part
  std::shared_ptr<const data::TableText> rows{};
  bool is_read = false;
};

InventoryBatches::InventoryBatches(const data::TableSource& source,
                                   const InventoryOptions& options,
                                   std::size_t rows,
                                   BatchOf of) {
  const bool is_file = std::holds_alternative<std::filesystem::path>(source);
  if (of != BatchOf::kTable && !is_file) {
    throw UsageError("only CSV files can be read plot by plot", {.column = "`stream`"});
  }
  InventoryReader reader(source, options, of);
  auto parts = reader.parts(rows);
  state_ = std::make_unique<State>(State{std::move(reader), of, std::move(parts)});
}

InventoryBatches::~InventoryBatches() = default;
InventoryBatches::InventoryBatches(InventoryBatches&&) noexcept = default;
InventoryBatches& InventoryBatches::operator=(InventoryBatches&&) noexcept = default;

std::optional<CheckedInventory> InventoryBatches::next() {
  State& state = *state_;
  while (!state.is_read) {
    if (state.parts) {
      state.rows = state.parts->next();
      if (!state.rows) break;
      state.reader.open(state.rows);
    } else {
      state.is_read = true;
    }
    CheckedInventory batch = state.reader.read();
    batch.is_in_file_order = !is_sorted();
    if (batch.inventory.size() > 0 || !batch.excluded.empty()) return batch;
  }
  if (!std::exchange(state.is_read, true)) state.reader.require_trees();
  return std::nullopt;
}

const std::shared_ptr<const data::TableText>& InventoryBatches::rows() const {
  return state_->rows;
}

std::size_t InventoryBatches::row_count() const {
  return state_->parts ? state_->parts->rows() : 0;
}

std::vector<std::string> InventoryBatches::notes() const { return state_->reader.notes(); }

std::vector<std::string> InventoryBatches::recognized() const {
  return state_->reader.recognized();
}

bool InventoryBatches::is_sorted() const { return state_->parts && state_->parts->is_sorted(); }

bool InventoryBatches::has_numbers() const { return state_->reader.has_tree_numbers(); }

std::string InventoryBatches::excluded() const { return state_->reader.excluded(); }

CheckedInventory read_inventory(const data::TableSource& source, const InventoryOptions& options) {
  return InventoryReader(source, options, BatchOf::kTable).read();
}

}  // namespace silvafit::stand
