// SPDX-License-Identifier: MIT
// The sums over plots from which values of strata are estimated.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "figures/ratio_estimates.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {

/// A value for each plot; plots of further parts of an inventory are appended.
struct PlotSums {
  std::vector<std::size_t> trees{};
  std::vector<char> has_area{};
  PlotTotals areas_ha{};  ///< in the population
  PlotTotals whole_ha{};  ///< of whole plots
  PlotTotals stems{};
  PlotTotals basal_areas_m2{};
  std::vector<PlotTotals> quantities{};
  std::vector<PlotTotals> stems_with_quantity{};
  PlotTotals heights_m{};
  PlotTotals stems_with_height{};

  void add(const Inventory& inventory, const std::vector<SampledArea>& areas);
};

/// Estimates by stratum and, last, for all together.
///
/// Plots are a simple random sample of their stratum. Per hectare: the ratio R = sum y / sum a of
/// the plots' values and areas; standard error sqrt(sum (y - R a)^2 / (n (n - 1))) / mean a,
/// which is that of the mean if plots are equal (Cochran 1977, chapter 6). Over strata:
/// weighted by their areas if all are known (chapter 5), else all plots are one sample. Means over
/// trees are ratios of two such totals, sum of heights to number of trees with a height, with the
/// standard error of the combined ratio (chapter 6.11), which is that of the total of y - R x
/// divided by the total of x; for the quadratic mean diameter with the first term of a Taylor
/// series. Plots without a stratum have an entry of their own after the strata, and are not in the
/// values of all that are weighted by areas.
/// \param stratum_of_plot   the stratum of each plot, empty if it has none; no entries: no strata,
///                          and the result is one entry
/// \param stratum_areas_ha  areas by name; may be empty
/// \param are_weights       they are relative areas, which give no totals
/// \throws UsageError if an area is given for an unknown stratum, or not for all strata, or
///   `settings` need areas of strata that are not given, or are smaller than those of the plots
std::vector<StratumFigures> stratum_figures(const PlotSums& plots,
                                            const std::vector<std::string>& stratum_of_plot,
                                            const std::map<std::string, double>& stratum_areas_ha,
                                            bool are_weights,
                                            const StratumSettings& settings);

}  // namespace silvafit::stand
