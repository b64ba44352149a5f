// SPDX-License-Identifier: MIT
// Stand tables of an inventory, from a file or table to results.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/stand_report.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

struct StandOptions {
  ReadingSettings reading{};
  UnitSettings units{};
  SamplingSettings sampling{};
  EquationSettings equations{};        ///< of volume, biomass and carbon
  stand::StandReportOptions report{};  ///< its `units` and `design` come from the settings
  /// Reads plot by plot, so that memory grows with the number of plots, not of trees; if the rows
  /// of a plot are not contiguous, they are sorted on disk.
  bool stream = false;
  unsigned threads = 0;  ///< 0: as many as there are cores
};

struct StandSummary {
  UnitSettings settings{};
  stand::CheckedInventory inventory{};  ///< with `stream` without trees and skipped rows
  stand::StandReport report{};          ///< with `stream` as of stand::StandReportParts
  std::vector<std::string> notes{};     ///< on the inventory and the report
  double seconds = 0.0;
};

/// Receives the trees of the inventory, or of one batch of it, with their structural units.
using StandUnitSink =
    std::function<void(const stand::CheckedInventory&, const stand::StructuralUnits&)>;

/// Reads an inventory and computes its stand report.
/// stand::tables_of and stand::write_stand turn the report into tables and files.
/// \throws UsageError if settings cannot be used; else as stand::read_inventory and
///   stand::stand_report
StandSummary stand_summary(const data::TableSource& inventory,
                           const StandOptions& options = {},
                           const Callbacks& callbacks = {},
                           const StandUnitSink& sink = {});

/// As JSON, schema silvafit-stand/1 (docs/stand.md).
nlohmann::ordered_json json_of(const StandSummary& summary);

}  // namespace silvafit::study
