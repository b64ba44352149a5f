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

/// stratum_figures() of these plots.
std::vector<StratumFigures> stratum_figures(const PlotSums& plots,
                                            const std::vector<std::string>& stratum_of_plot,
                                            const std::map<std::string, double>& stratum_areas_ha,
                                            bool are_weights,
                                            const StratumSettings& settings);

}  // namespace silvafit::stand
