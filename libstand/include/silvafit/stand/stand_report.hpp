// SPDX-License-Identifier: MIT
// All tables of a stand in one object.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/stand/clark_evans.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/sampling_design.hpp"
#include "silvafit/stand/species_table.hpp"
#include "silvafit/stand/stand_summary.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/structure_classes.hpp"
#include "silvafit/stand/unit_summary.hpp"

namespace silvafit::stand {

struct StandReportOptions {
  StructuralUnitOptions units{};
  SpeciesTableOptions species{};  ///< quadrat_m 0 in a stand of one plot: quadrats of 10 m
  double class_width_cm = 4.0;
  /// How trees and plots were chosen. A table of plots gives strata, too, and areas if there are
  /// neither windows nor plot_area_m2.
  SamplingDesign design{};
  /// Area of every plot, for inventories without windows; do not give both.
  std::optional<double> plot_area_m2{};
  /// Column of Inventory::other with each tree's stratum; empty: none.
  std::string stratum{};
  std::map<std::string, double> stratum_areas_ha{};
  StratumSettings strata{};
  /// Columns whose values make StandReport::domains: species, dbh for classes of diameters, others.
  std::vector<std::string> by{};
  bool without_areas = false;  ///< areas are unknown: values per hectare are missing
  bool without_units = false;  ///< without structural units
  bool trust_units = false;    ///< do not check whether areas make possible basal areas
};

/// A plot, or the stand if plots have no window of their own.
struct AreaReport {
  SampledArea area{};
  std::string stratum{};  ///< empty if it has none
  StandFigures figures{};
  std::optional<ClarkEvans> clark_evans{};  ///< only with a window
};

struct NamedJointDistribution {
  std::string first{};
  std::string second{};
  JointDistribution distribution{};
};

/// Stand values, species, diameters and structure of an inventory.
struct StandReport {
  std::vector<AreaReport> areas{};
  StandFigures all{};                     ///< all areas together
  std::vector<std::string> quantities{};  ///< names and units, such as volume_m3
  std::vector<StratumFigures> strata{};   ///< the last entry: all strata together
  std::vector<std::string> by{};          ///< StandReportOptions::by
  std::vector<DomainFigures> domains{};   ///< by these
  std::vector<SpeciesRow> species{};
  Layers layers{};
  double quadrat_m = 0.0;  ///< 0: plots were the quadrats
  double dominant_trees_per_ha = 0.0;
  std::vector<DiameterClass> diameters{};
  std::optional<StructuralUnits> units{};  ///< none without positions
  std::optional<UnitSummary> unit_means{};
  std::vector<UnitSummary> unit_means_by_species{};
  std::vector<NamedJointDistribution> joint{};  ///< (W, M), (U, M), (C, M)
  std::vector<std::string> notes{};
};

/// \throws InputError if the areas make more basal area than any forest has;
///         UsageError if windows and a plot area are given, neither positions nor a plot area are
///         known, a plot is in several strata, or an option is out of range; else as
///         structural_units and plot_windows
StandReport stand_report(const Inventory& inventory, const StandReportOptions& options);

class ReportMaker;

/// stand_report() of an inventory that is read in parts of whole plots (InventoryBatches), with the
/// same bytes. Neither trees nor windows are kept, so that memory grows with the number of plots
/// only; trees are sorted by size on disk for the dominant heights.
class StandReportParts {
 public:
  /// \param is_only_plot  whether the whole inventory has only one plot
  /// \throws UsageError if there is a sampling design, or neighbors are searched in the stand
  StandReportParts(const StandReportOptions& options, bool is_only_plot);
  ~StandReportParts();
  StandReportParts(StandReportParts&&) noexcept;
  StandReportParts& operator=(StandReportParts&&) noexcept;

  /// \param part  may have no tree
  /// \return the structural units of the part, until the next call; null if there are none
  /// \throws as stand_report()
  const StructuralUnits* add(const Inventory& part);
  /// The report; its areas are without trees and windows, and its units without trees.
  /// \param file  for messages
  StandReport finish(const std::string& file);

 private:
  std::unique_ptr<ReportMaker> maker_;
};

}  // namespace silvafit::stand
