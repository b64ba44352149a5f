// SPDX-License-Identifier: MIT
// Tables of plots: one row per plot, or per plot and date, with areas, positions and strata.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// A row of a table of plots. Numbers are NaN and texts empty where they are missing.
struct PlotRecord {
  std::size_t line = 0;
  std::string plot{};
  std::string stratum{};
  std::string estimation_unit{};           ///< StratumSettings::unit_of_stratum
  std::string time{};                      ///< year or date of the measurement, as written
  double area_m2 = data::kMissing;         ///< > 0
  double radius_m = data::kMissing;        ///< > 0
  double expansion = data::kMissing;       ///< trees per ha that each tree stands for, > 0
  double slope_deg = data::kMissing;       ///< in [0, 90)
  double share = data::kMissing;           ///< of the plot that lies in the population, in [0, 2]
  double x = data::kMissing;               ///< center, east [m]
  double y = data::kMissing;               ///< center, north [m]
  double stratum_ha = data::kMissing;      ///< area of the stratum, >= 0
  double stratum_weight = data::kMissing;  ///< relative area of the stratum, >= 0
};

struct PlotTable {
  std::string file{};
  std::vector<PlotRecord> plots{};
  bool has_stratum = false;
  bool has_time = false;
  bool has_slope = false;
  bool slope_lacks_unit = false;  ///< the header does not say that it is in degrees
  bool has_center = false;
  std::string recognized{};  ///< note on columns with other usual names
};

/// Reads a table of plots: plot, and any of area, radius, expansion, slope (degrees) or
/// slope_percent, share, x, y, stratum, stratum_area, stratum_weight, estimation_unit, year or
/// date; docs/plots.md has their usual names and units. The table may be an inventory, with a row
/// for each tree (a column of dbh): rows of a plot then have the same numbers, and x, y and
/// expansion are those of trees and not read. \param columns  `name=source`: where columns come
/// from, as for inventories \throws InputError if the column plot is missing, a plot is listed
/// twice (for one year or date),
///         or values cannot be right (with the first problems); UsageError if a name of `columns`
///         is none of these
PlotTable read_plot_table(const data::TableSource& source,
                          const std::vector<ColumnMapping>& columns = {});

/// The column of an inventory with a usual name of the area of plots; empty if there is none.
std::string plot_area_column(const std::vector<std::string>& header);

/// How to use Inventory::area_column and Inventory::factors, as the end of a message; empty if
/// there are none.
std::string offer_of_area_column(const Inventory& inventory);

/// \throws InputError if trees of one plot have different expansion factors that are not used, as
///         they then stand for different areas
void refuse_unused_factors(const Inventory& inventory);

}  // namespace silvafit::stand
