// SPDX-License-Identifier: MIT
// Settings for reading a table of trees and for computing its structural units, with the names of
// study.json, model libraries, R, Python and the program. Errors name the field in Place::column.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/raster.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/prepared_table.hpp"
#include "silvafit/stand/sampling_design.hpp"
#include "silvafit/stand/structural_units.hpp"

namespace silvafit::study {

/// The rows of a table, as stand::RowPreparation.
struct RowSettings {
  std::string where{};                ///< condition for the rows to use; empty: all
  std::vector<std::string> visits{};  ///< `dbh=DBH_{year}`: columns of several times
};

/// Settings for reading a table of trees.
struct ReadingSettings {
  std::vector<std::string> columns{};  ///< `dbh=DBH_cm`: where columns come from
  bool trust_units = false;            ///< do not check whether columns or plots have another unit
  std::vector<std::string> missing{};  ///< further texts and numbers for missing values
  std::vector<std::string> fill_down{};  ///< columns whose empty fields have the value above
  stand::DeadTrees dead = stand::DeadTrees::kLeaveOut;
  std::vector<std::string> alive_codes{};  ///< values of the status column
  std::vector<std::string> dead_codes{};
  std::vector<std::string> cut_codes{};
  bool case_sensitive = false;  ///< species that differ only in capitals are different
  RowSettings rows{};
  /// On which trees stand that are drawn, instead of their column z; null: none.
  std::shared_ptr<const data::Raster> terrain{};
};

/// Settings of structural units; stand::StructuralUnitOptions explains the values.
struct UnitSettings {
  std::string window{};  ///< file of stand::read_windows
  std::string circle{};  ///< `x,y,radius` of every plot [m], instead of a window
  std::vector<stand::NamedWindow> windows{};  ///< in memory, instead of both
  stand::EdgeCorrection edge = stand::EdgeCorrection::kBuffer;
  double buffer_m = 5.0;
  stand::SearchScope per = stand::SearchScope::kPlot;
  std::size_t neighbors = 4;
  std::vector<std::string> alpha{};  ///< limit angles of W [degrees]: `72`, `SM=60`
  stand::SizeMeasure dominance = stand::SizeMeasure::kDbh;
  stand::CrownReach crowding = stand::CrownReach::kMeanWidth;
  std::vector<std::string> further{};  ///< CO, T, Hegyi, BAL, CCF, or all
  double competition_radius_m = 0.0;
  std::string open_grown{};  ///< for CCF: crown width [m], an expression of dbh

  /// Whether an index is one of the further ones, by its name or by "all".
  bool wants(std::string_view index) const {
    return std::ranges::any_of(
        further, [index](const std::string& name) { return name == index || name == "all"; });
  }
};

/// Sampling of plots and trees; stand::SamplingDesign explains the values.
struct SamplingSettings {
  std::string plots_file{};                  ///< table of plots, a CSV file
  std::optional<data::TableSource> plots{};  ///< the table itself, instead of the file
  std::vector<std::string> plots_columns{};  ///< `area=SIZE_M2`: where its columns come from
  std::vector<std::string> circles{};        ///< `7=4`: trees from 7 cm up to 4 m
  double angle_count = 0.0;                  ///< basal area factor [m2/ha]
  double smallest_dbh_cm = 0.0;              ///< of angle counts
  std::string expansion{};                   ///< column of the inventory [trees/ha]
  bool expansion_area = false;  ///< these hectares are those of the plot's part in the population
  std::size_t subplots = 1;
  std::string subplot{};  ///< column of the inventory
  bool slope_correction = false;

  bool has_plots() const { return plots || !plots_file.empty(); }
};

/// The design, with the table of plots read.
/// \throws UsageError if a text cannot be read or the design contradicts itself; else as
///   stand::read_plot_table
stand::SamplingDesign sampling_design(const SamplingSettings& settings);

/// Columns of the inventory that a design needs.
std::vector<std::string> columns_of(const SamplingSettings& settings);

/// The options of an inventory's reader by these settings; a caller may add its own.
/// \throws UsageError if a column or a word cannot be read
stand::InventoryOptions inventory_options(const ReadingSettings& settings,
                                          stand::InventoryOptions options = {});

/// The requested further indices; "all" are those that need no further settings, and CCF
/// if `open_grown` gives its crown widths.
/// \throws UsageError if a name is none of them
std::vector<stand::FurtherIndex> further_indices(const UnitSettings& settings);

/// The options of stand::structural_units, with the windows read from their file.
/// \param threads  0: as many as there are cores
/// \throws UsageError if a word or number cannot be read; else as stand::read_windows
stand::StructuralUnitOptions unit_options(const UnitSettings& settings, unsigned threads = 0);

}  // namespace silvafit::study
