// SPDX-License-Identifier: MIT
// Means of the structural indices by species.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::stand {

/// Trees of one species, or of all, and the means of the indices of its core trees, weighted if the
/// edge correction has weights; NaN where no core tree has the index.
struct UnitSummary {
  std::string species{};  ///< empty for trees without species
  std::size_t trees = 0;
  std::size_t core_trees = 0;
  double W = 0.0;
  double M = 0.0;
  double U = 0.0;
  double C = 0.0;
  std::vector<double> further{};  ///< in the order of StructuralUnits::further
};

/// Accumulates means over several inventories, such as the batches of a large one.
class UnitSummaries {
 public:
  UnitSummaries();
  ~UnitSummaries();
  UnitSummaries(UnitSummaries&&) noexcept;
  UnitSummaries& operator=(UnitSummaries&&) noexcept;

  /// \param units  with the same further indices each time
  void add(const Inventory& inventory, const StructuralUnits& units);

  /// One entry per species, in the order of the species' first trees; trees without species last.
  std::vector<UnitSummary> by_species() const;
  /// All trees together; `species` stays empty.
  UnitSummary all() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace silvafit::stand
