// SPDX-License-Identifier: MIT
// Growth between repeated measurements: increments of trees, ingrowth, mortality and cut.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/stand_report.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {

/// The fate of a tree between two measurements of its plot.
enum class TreeFate {
  kSurvivor,
  kIngrowth,  ///< alive at the end, no row before
  kMortality,
  kCut,       ///< cut, fallen or a stump at the end
  kNotFound,  ///< alive at the start, without a row at the end and later
};
constexpr std::array<std::string_view, 5> words_of(TreeFate /*fate*/) {
  return {"survivor", "ingrowth", "mortality", "cut", "not found"};
}

/// A tree in a period. Values are NaN where they were not measured.
struct TreeGrowth {
  std::string plot{};
  std::string tree{};
  std::string species{};
  std::string from{};  ///< times as written
  std::string to{};
  double years = 0.0;
  TreeFate fate = TreeFate::kSurvivor;
  double dbh_start_cm = 0.0;
  double dbh_end_cm = 0.0;
  double h_start_m = 0.0;
  double h_end_m = 0.0;
  /// Periodic annual increments: the difference divided by the years.
  double dbh_cm_per_year = 0.0;
  double h_m_per_year = 0.0;
  double basal_area_cm2_per_year = 0.0;
  std::vector<double> quantities_per_year{};  ///< of Inventory::quantities
  bool is_interpolated = false;  ///< start or end lies between two measurements of the tree
  bool is_renamed = false;       ///< it has another species at the end
};

/// Parts of growth, per hectare: stocks at the start and end, and changes per year.
enum class GrowthPart {
  kStart,
  kEnd,
  kNetChange,       ///< (end - start) / years
  kSurvivorGrowth,  ///< of trees alive at both, with their expansion factor at the start
  kIngrowth,
  kMortality,  ///< positive
  kCut,
  kNotFound,
  kFactorChange,  ///< the rest of the net change: trees whose expansion factor changed
  kCount
};
inline constexpr std::size_t kGrowthParts = static_cast<std::size_t>(GrowthPart::kCount);
constexpr std::array<std::string_view, kGrowthParts> words_of(GrowthPart /*part*/) {
  return {"start",
          "end",
          "net_change",
          "survivor_growth",
          "ingrowth",
          "mortality",
          "cut",
          "not_found",
          "factor_change"};
}

/// A value for each part.
using GrowthParts = std::array<double, kGrowthParts>;

/// A plot between two of its measurements.
struct PlotGrowth {
  std::string plot{};
  std::string stratum{};
  std::string from{};
  std::string to{};
  std::size_t period = 0;  ///< number of the plot's period, from 1
  double years = 0.0;
  double area_ha = 0.0;               ///< NaN if unknown
  std::vector<GrowthParts> values{};  ///< by GrowthReport::values, per hectare
};

/// Plots of one stratum, or of all, in periods of one number.
struct StratumGrowth {
  StratumFigures::Kind kind = StratumFigures::Kind::kStratum;
  std::string name{};
  std::size_t period = 0;
  std::string from{};  ///< earliest start of a plot
  std::string to{};    ///< latest end
  std::size_t plots = 0;
  std::vector<std::array<Estimate, kGrowthParts>> values{};
};

struct GrowthReport {
  std::vector<std::string> quantities{};  ///< names of Inventory::quantities with units
  std::vector<std::string> values{};      ///< stems, basal_area_m2, and the quantities
  std::vector<TreeGrowth> trees{};
  std::vector<PlotGrowth> plots{};
  std::vector<StratumGrowth> strata{};  ///< by period; the last of a period: all strata
  std::vector<std::string> notes{};
};

/// Growth of an inventory with repeated measurements (InventoryOptions::keeps_measurements).
///
/// A period of a plot lies between two consecutive times of its rows. A tree that was alive before
/// and after a time at which it has no row survived; its values then are interpolated. Expansion
/// factors are those of the sampling design at each time. The parts sum up to the net change:
/// end = start + years (survivor growth + ingrowth - mortality - cut - not found + factor change).
/// Estimates over plots are those of stratum_figures, of annual changes.
/// Source: Beers 1962 (components); Martin 1982 and Van Deusen and others 1986 (factors that
/// change); Kershaw and others 2017, chapter 14.
/// \param options  areas, design and strata as for stand_report; without areas the values per
///                 hectare are NaN
/// \throws InputError if there is no time, a time is not a year or date, or no plot has two times
GrowthReport growth_report(const Inventory& inventory, const StandReportOptions& options);

/// growth_trees, growth_plots and growth_strata (a row for each value and part).
std::vector<std::pair<std::string, data::Table>> tables_of(const GrowthReport& report);

/// Numbers of trees by fate, plots and strata, as docs/plots.md describes them.
nlohmann::ordered_json json_of(const GrowthReport& report);

}  // namespace silvafit::stand
