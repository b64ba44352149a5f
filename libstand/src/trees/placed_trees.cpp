// SPDX-License-Identifier: MIT
#include "silvafit/stand/placed_trees.hpp"

#include "trees/inventory_reader.hpp"

namespace silvafit::stand {

struct PlacedTrees::State {
  InventoryReader reader;
  std::size_t trees;
};

PlacedTrees::PlacedTrees(const std::filesystem::path& path,
                         const InventoryOptions& options,
                         std::size_t trees)
    : state_(std::make_unique<State>(State{InventoryReader(path, options, true), trees})) {}

PlacedTrees::~PlacedTrees() = default;
PlacedTrees::PlacedTrees(PlacedTrees&&) noexcept = default;
PlacedTrees& PlacedTrees::operator=(PlacedTrees&&) noexcept = default;

std::optional<CheckedInventory> PlacedTrees::next() {
  return state_->reader.read_rows(state_->trees);
}

std::vector<std::string> PlacedTrees::notes() const { return state_->reader.notes(); }

std::string PlacedTrees::excluded() const { return state_->reader.excluded(); }

bool PlacedTrees::has_numbers() const { return state_->reader.has_tree_numbers(); }

}  // namespace silvafit::stand
