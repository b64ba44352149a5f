// SPDX-License-Identifier: MIT
// Stand tables of an inventory, and growth between its repeated measurements, from a file or table
// to results.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/growth.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/stand_report.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/study_record.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

struct StandOptions {
  ReadingSettings reading{};
  UnitSettings units{};
  SamplingSettings sampling{};
  EquationSettings equations{};       ///< of volume, biomass and carbon
  std::vector<std::string> totals{};  ///< columns that are quantities, too
  std::string thinning{};             ///< as stand::parse_thinning(); empty: none
  /// Curve of models/site_index (of `equations.models`); reads the column age of the trees.
  std::string site_index{};
  stand::StandReportOptions report{};  ///< its `units` and `design` come from the settings
  /// Reads plot by plot, so that memory grows with the number of plots, not of trees; if the rows
  /// of a plot are not contiguous, they are sorted on disk.
  bool stream = false;
  unsigned threads = 0;  ///< 0: as many as there are cores
};

/// \throws UsageError that names a setting without effect on stand tables
void refuse_idle(const StandOptions& options, const GivenName& given_name = {});

struct StandSummary {
  UnitSettings settings{};
  stand::CheckedInventory inventory{};  ///< with `stream` without trees and skipped rows
  stand::StandReport report{};          ///< with `stream` as of stand::StandReportParts
  std::optional<stand::Thinning> thinning{};
  std::vector<SiteIndex> sites{};
  std::vector<std::string> notes{};  ///< on the inventory and the report
  double seconds = 0.0;
};

/// Receives the trees of the inventory, or of one batch of it, with their structural units.
using StandUnitSink =
    std::function<void(const stand::CheckedInventory&, const stand::StructuralUnits&)>;

/// Reads an inventory and computes its stand report.
/// stand::tables_of turns the report into tables.
/// \throws UsageError if settings cannot be used; else as stand::read_inventory and
///   stand::stand_report
StandSummary stand_summary(const data::TableSource& inventory,
                           const StandOptions& options = {},
                           const Callbacks& callbacks = {},
                           const StandUnitSink& sink = {});

/// Writes the report page of stand tables: those, diameters, height curves by Naslund's formula and
/// the map.
/// \param summary        not read with `stream`
/// \param command        as it was given
/// \param page_template  as of write_study()
void write_stand_page(StandSummary summary,
                      const StandOptions& options,
                      const Catalogue& catalogue,
                      const std::string& command,
                      const std::filesystem::path& page_template,
                      const std::filesystem::path& file);

/// The tables of the report, and those of thinning and site indices: `thinning` with the stand
/// before, the removed trees and the stand after, `trees` with the column `removed`, `sites`.
std::vector<std::pair<std::string, data::Table>> tables_of(const StandSummary& summary);

/// As JSON, schema silvafit-stand/1 (docs/stand.md).
nlohmann::ordered_json json_of(const StandSummary& summary);

/// \throws UsageError that names a setting without effect on growth
void refuse_idle_on_growth(const StandOptions& options, const GivenName& given_name = {});

struct GrowthSummary {
  stand::CheckedInventory inventory{};
  stand::GrowthReport report{};
  std::vector<std::string> notes{};  ///< on the inventory and the report
  double seconds = 0.0;
};

/// Reads an inventory with the rows of all times and computes the growth of trees, plots and
/// strata. stand::tables_of turns the report into tables.
/// \throws as stand_summary and stand::growth_report
GrowthSummary stand_growth(const data::TableSource& inventory,
                           const StandOptions& options = {},
                           const Callbacks& callbacks = {});

/// As JSON, schema silvafit-growth/1 (docs/plots.md).
nlohmann::ordered_json json_of(const GrowthSummary& summary);

}  // namespace silvafit::study
