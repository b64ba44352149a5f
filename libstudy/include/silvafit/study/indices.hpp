// SPDX-License-Identifier: MIT
// The structural indices of every tree of an inventory, from a file or table to results.
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

struct IndicesOptions {
  ReadingSettings reading{};
  UnitSettings units{};
  SamplingSettings sampling{};
  /// Reads plot by plot, so that memory does not grow with the file; if the rows of a plot are not
  /// contiguous, they are sorted on disk. Neighbors are searched within plots.
  bool stream = false;
  unsigned threads = 0;  ///< 0: as many as there are cores
};

/// \throws UsageError that names a setting without effect
void refuse_idle(const IndicesOptions& options, const GivenName& given_name = {});

/// Results and notes on all trees together.
struct IndicesSummary {
  std::string inventory{};  ///< file; empty for a table in memory
  UnitSettings settings{};
  stand::UnitSummaries summaries{};
  std::vector<stand::FurtherIndex> further{};  ///< those computed, in the order of the results
  std::size_t excluded_trees = 0;
  double alpha0_deg = 0.0;
  std::vector<std::string> recognized{};  ///< how the inventory was read
  std::vector<std::string> notes{};       ///< these, and notes on assumptions
  double seconds = 0.0;                   ///< with reading
  double seconds_units = 0.0;             ///< of the structural units alone
};

/// As JSON, schema silvafit-indices/1 (docs/json.md).
nlohmann::ordered_json json_of(const IndicesSummary& summary);

/// Receives the trees of the inventory, or of one batch of it, with their units; of a batch without
/// a usable row, no units.
using UnitSink = std::function<void(stand::CheckedInventory&, stand::StructuralUnits&)>;

/// Computes the structural unit of every tree and passes them to a callback.
/// \throws UsageError if settings cannot be used; else as stand::read_inventory and
///   stand::structural_units
IndicesSummary compute_indices(const data::TableSource& inventory,
                               const IndicesOptions& options,
                               const UnitSink& sink,
                               const Callbacks& callbacks = {});

/// An inventory with its structural units.
struct TreeIndices {
  stand::CheckedInventory inventory{};
  stand::StructuralUnits units{};
  IndicesSummary summary{};

  /// Our columns of the inventory, then core, W, M, U, C and the further indices.
  data::Table table() const;
};

/// The same, all in memory.
TreeIndices tree_indices(const data::TableSource& inventory,
                         const IndicesOptions& options = {},
                         const Callbacks& callbacks = {});

/// Reads an inventory and reports its notes and skipped rows.
/// \param options  requirements of the caller; the settings are filled in
stand::CheckedInventory read_inventory(const data::TableSource& inventory,
                                       const ReadingSettings& settings,
                                       const stand::InventoryOptions& options,
                                       const NoteCallback& note = {});

}  // namespace silvafit::study
