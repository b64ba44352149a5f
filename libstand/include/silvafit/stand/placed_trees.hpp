// SPDX-License-Identifier: MIT
// The trees of a file in their order, in parts that may split plots.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// Reads the trees of an inventory in parts, checked row by row as read_inventory does, but not
/// compared with each other: repeated tree numbers and spellings of species are kept.
class PlacedTrees {
 public:
  /// \throws as InventoryBatches
  PlacedTrees(const std::filesystem::path& path,
              const InventoryOptions& options,
              std::size_t trees = 200000);
  ~PlacedTrees();
  PlacedTrees(PlacedTrees&&) noexcept;
  PlacedTrees& operator=(PlacedTrees&&) noexcept;

  /// The next part, without notes; nothing at the end. Units are checked in the first part.
  /// \throws InputError if no row can be used
  std::optional<CheckedInventory> next();
  /// As those of InventoryBatches.
  std::vector<std::string> notes() const;
  std::string excluded() const;
  /// Whether the file numbers its trees.
  bool has_numbers() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace silvafit::stand
