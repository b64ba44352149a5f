// SPDX-License-Identifier: MIT
// Ratios of sums over sampled plots, by stratum and over strata, with standard errors.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {

/// A value of a tree; NaN for trees that are not included.
using TreeValue = std::function<double(std::size_t tree)>;
/// A sum over the trees of each plot, or its area.
using PlotTotals = std::vector<double>;
/// Numbers of plots in such a list.
using PlotNumbers = std::vector<std::size_t>;

/// Sums over the trees of each plot, weighted by the number of trees that each represents.
PlotTotals totals_of(const Inventory& inventory,
                     const std::vector<SampledArea>& areas,
                     const TreeValue& value);

/// A stratum with its area or weight.
struct SizedStratum {
  PlotNumbers plots{};
  double size = 1.0;
  /// Share of its area that plots cover; variances are those of the rest (Cochran 1977, 2.6).
  double covered = 0.0;
  std::string unit{};  ///< StratumSettings::unit_of_stratum
};

struct SizedStrata {
  std::vector<SizedStratum> list{};
  /// Plots were assigned to strata after they were chosen from all: StratumSettings.
  bool are_posterior = false;
};

/// The ratio R of two sums over plots (Cochran 1977, chapter 6) with standard error
/// sqrt((1 - f) sum (y - R x)^2 / (n (n - 1))) / mean x, f the share covered; NaN if fewer
/// than two plots have a size.
Mean ratio_of_sums(const PlotTotals& values, const PlotTotals& sizes, const SizedStratum& stratum);

/// The areas of plots to which areas of strata refer. A plot without any part in the population
/// (area 0) was drawn from land outside of it; strata then are land, and whole plots are its
/// sample. Otherwise they are the population.
const PlotTotals& areas_of_strata(const PlotTotals& in_population, const PlotTotals& whole);

/// The sum over strata of the mean per hectare times the size of the stratum. Strata of size 0 add
/// nothing. With W the shares of strata in the sum of sizes, n numbers of plots and v the variances
/// of means, the variance of the mean is sum W^2 v or, for posterior strata of an estimation unit,
/// sum W n v / N + sum (1 - W) n v / N^2, N all plots (Bechtold and Patterson 2005, 4.2; Cochran
/// 1977, 5A.9).
Mean total_of(const PlotTotals& values, const PlotTotals& areas_ha, const SizedStrata& strata);

/// The combined ratio of the totals of two values (Cochran 1977, 6.11); NaN if the second is 0,
/// and without a standard error if it is not 0 in one plot only.
Mean combined_ratio(const PlotTotals& values,
                    const PlotTotals& counts,
                    const PlotTotals& areas_ha,
                    const SizedStrata& strata);

/// Per hectare, without a total.
Estimate estimate_of(const Mean& per_ha);

/// Per hectare of the population of all strata, the combined ratio of the values to the areas, with
/// the total if the sizes of strata are areas.
/// \param of_strata  areas_of_strata()
Estimate over_strata(const PlotTotals& values,
                     const PlotTotals& areas_ha,
                     const PlotTotals& of_strata,
                     const SizedStrata& strata,
                     bool are_weights);

/// Sets the total of one stratum.
void add_total(Estimate& estimate,
               const PlotTotals& values,
               const PlotTotals& of_strata,
               const SizedStratum& stratum);

/// \throws UsageError if a size is below 0 or of an unknown stratum, one is missing, or all are 0
void check_stratum_sizes(const std::set<std::string>& names,
                         const std::map<std::string, double>& sizes);

}  // namespace silvafit::stand
