// SPDX-License-Identifier: MIT
// Stand tables of an inventory, from a file or table to results.
#pragma once

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
  /// Areas of strata in ha, `A=120`, besides those of `report`.
  std::vector<std::string> stratum_areas{};
  unsigned threads = 0;  ///< 0: as many as there are cores
};

struct StandSummary {
  UnitSettings settings{};
  stand::CheckedInventory inventory{};
  stand::StandReport report{};
  std::vector<std::string> notes{};  ///< on the inventory and the report
  double seconds = 0.0;
};

/// Reads an inventory and computes its stand report.
/// stand::tables_of and stand::write_stand turn the report into tables and files.
/// \throws UsageError if settings cannot be used; else as stand::read_inventory and
///   stand::stand_report
StandSummary stand_summary(const data::TableSource& inventory,
                           const StandOptions& options = {},
                           const Callbacks& callbacks = {});

/// As JSON, schema silvafit-stand/1 (docs/stand.md).
nlohmann::ordered_json json_of(const StandSummary& summary);

}  // namespace silvafit::study
