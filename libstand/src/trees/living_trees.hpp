// SPDX-License-Identifier: MIT
// The living trees of repeated measurements.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// The living trees of all times as an inventory in which each plot and time is a plot, so that
/// areas, designs and expansion factors are those of any inventory.
class LivingTrees {
 public:
  explicit LivingTrees(const Inventory& source) : source_(source) {}

  /// \return the number of the row
  std::size_t add(std::size_t row, const std::string& label);
  /// A tree between two of its rows.
  std::size_t add_between(std::size_t first,
                          std::size_t second,
                          double share,
                          const std::string& label);
  Inventory finish() &&;

 private:
  const Inventory& source_;
  std::vector<std::size_t> rows_{};
  Inventory result_{};
};

}  // namespace silvafit::stand
