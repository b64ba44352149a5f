// SPDX-License-Identifier: MIT
// Design-based estimates by stratum.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "figures/plot_sums.hpp"
#include "figures/ratio_estimates.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/stand_summary.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {
namespace {

class Estimator {
 public:
  explicit Estimator(const PlotSums& plots)
      : plots_(plots), of_strata_(areas_of_strata(plots.areas_ha, plots.whole_ha)) {}

  StratumFigures of_plots(const SizedStratum& stratum, std::string name) const;
  double covered(const PlotNumbers& plots, double size_ha, const std::string& name) const;
  void add_totals(const SizedStratum& stratum, StratumFigures& result) const;
  void combine(const SizedStrata& strata, bool are_weights, StratumFigures& result) const;

 private:
  void add_means(const SizedStrata& strata, StratumFigures& result) const;

  const PlotSums& plots_;
  const PlotTotals& of_strata_;
};

void append(PlotTotals& totals, const PlotTotals& more) {
  totals.insert(totals.end(), more.begin(), more.end());
}

void Estimator::add_means(const SizedStrata& strata, StratumFigures& result) const {
  result.mean_height_m =
      combined_ratio(plots_.heights_m, plots_.stems_with_height, of_strata_, strata);
  const Mean mean_basal_m2 =
      combined_ratio(plots_.basal_areas_m2, plots_.stems, of_strata_, strata);
  const double diameter_m = std::sqrt(4.0 / std::numbers::pi * mean_basal_m2.value);
  constexpr double kCentimetersPerMeter = 100.0;
  // d(dg)/d(g) = dg / (2 g)
  result.quadratic_mean_dbh_cm = {.value = kCentimetersPerMeter * diameter_m,
                                  .standard_error = kCentimetersPerMeter * diameter_m *
                                                    mean_basal_m2.standard_error /
                                                    (2.0 * mean_basal_m2.value)};
  result.quantities_of_tree.clear();
  for (std::size_t i = 0; i < plots_.quantities.size(); ++i) {
    result.quantities_of_tree.push_back(
        combined_ratio(plots_.quantities[i], plots_.stems_with_quantity[i], of_strata_, strata));
  }
}

/// The share of a stratum's area that its plots cover.
double Estimator::covered(const PlotNumbers& plots, double size_ha, const std::string& name) const {
  double sampled_ha = 0.0;
  for (const std::size_t plot : plots) {
    if (plots_.has_area[plot] == 0) {
      throw UsageError(
          "the share of a stratum in plots without area is unknown; omit `finite_population`",
          {.column = "`finite_population`"});
    }
    sampled_ha += of_strata_[plot];
  }
  if (sampled_ha <= size_ha) return size_ha > 0.0 ? sampled_ha / size_ha : 0.0;
  throw UsageError(fmt::format("the plots of stratum '{}' cover {:.6g} ha, more than its area of "
                               "{:.6g} ha",
                               name,
                               sampled_ha,
                               size_ha),
                   {.column = "`stratum_areas`"});
}

StratumFigures Estimator::of_plots(const SizedStratum& stratum, std::string name) const {
  const PlotNumbers& plots = stratum.plots;
  StratumFigures result{.name = std::move(name), .plots = plots.size(), .area_ha = data::kMissing};
  for (const std::size_t plot : plots) {
    result.trees += plots_.trees[plot];
    result.sampled_ha += plots_.has_area[plot] != 0 ? plots_.areas_ha[plot] : data::kMissing;
  }
  result.stems = estimate_of(ratio_of_sums(plots_.stems, plots_.areas_ha, stratum));
  result.basal_area_m2 =
      estimate_of(ratio_of_sums(plots_.basal_areas_m2, plots_.areas_ha, stratum));
  for (const PlotTotals& totals : plots_.quantities) {
    result.quantities.push_back(estimate_of(ratio_of_sums(totals, plots_.areas_ha, stratum)));
  }
  add_means({.list = {{.plots = plots, .covered = stratum.covered}}}, result);
  return result;
}

void Estimator::add_totals(const SizedStratum& stratum, StratumFigures& result) const {
  result.area_ha = stratum.size;
  add_total(result.stems, plots_.stems, of_strata_, stratum);
  add_total(result.basal_area_m2, plots_.basal_areas_m2, of_strata_, stratum);
  for (std::size_t i = 0; i < result.quantities.size(); ++i) {
    add_total(result.quantities[i], plots_.quantities[i], of_strata_, stratum);
  }
}

void Estimator::combine(const SizedStrata& strata, bool are_weights, StratumFigures& result) const {
  double size = 0.0;
  for (const SizedStratum& stratum : strata.list) size += stratum.size;
  result.area_ha = are_weights ? data::kMissing : size;
  const auto estimate = [&](const PlotTotals& values) {
    return over_strata(values, plots_.areas_ha, of_strata_, strata, are_weights);
  };
  result.stems = estimate(plots_.stems);
  result.basal_area_m2 = estimate(plots_.basal_areas_m2);
  result.quantities.clear();
  for (const PlotTotals& totals : plots_.quantities) result.quantities.push_back(estimate(totals));
  add_means(strata, result);
}

/// A quantity that none of the trees has is unknown, not 0.
void forget_unknown(StratumFigures& figures) {
  for (std::size_t i = 0; i < figures.quantities.size(); ++i) {
    const bool is_known = figures.trees == 0 || !std::isnan(figures.quantities_of_tree[i].value);
    if (is_known) continue;
    constexpr double kMissing = data::kMissing;
    figures.quantities[i] = {kMissing, kMissing, kMissing, kMissing};
  }
}

}  // namespace

void PlotSums::add(const Inventory& inventory, const std::vector<SampledArea>& areas) {
  const auto height = [&inventory](std::size_t tree) {
    return inventory.h_m.empty() ? data::kMissing : inventory.h_m[tree];
  };
  for (const SampledArea& area : areas) {
    trees.push_back(area.trees.size());
    has_area.push_back(area.has_area ? 1 : 0);
    areas_ha.push_back(area.area_m2 / kSquareMetersPerHectare);
    const double whole_m2 = std::isnan(area.whole_m2) ? area.area_m2 : area.whole_m2;
    whole_ha.push_back(whole_m2 / kSquareMetersPerHectare);
  }
  append(stems, totals_of(inventory, areas, [](std::size_t) { return 1.0; }));
  append(basal_areas_m2, totals_of(inventory, areas, [&inventory](std::size_t tree) {
           return basal_area_m2(inventory.dbh_cm[tree]);
         }));
  quantities.resize(inventory.quantities.size());
  stems_with_quantity.resize(quantities.size());
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const std::vector<double>& values = inventory.quantities[i].values;
    append(quantities[i],
           totals_of(inventory, areas, [&values](std::size_t tree) { return values[tree]; }));
    append(stems_with_quantity[i], totals_of(inventory, areas, [&values](std::size_t tree) {
             return std::isnan(values[tree]) ? data::kMissing : 1.0;
           }));
  }
  append(heights_m, totals_of(inventory, areas, height));
  append(stems_with_height, totals_of(inventory, areas, [&height](std::size_t tree) {
           return std::isnan(height(tree)) ? data::kMissing : 1.0;
         }));
}

std::vector<StratumFigures> stratum_figures(const PlotSums& plots,
                                            const std::vector<std::string>& stratum_of_plot,
                                            const std::map<std::string, double>& stratum_areas_ha,
                                            bool are_weights,
                                            const StratumSettings& settings) {
  std::map<std::string, PlotNumbers> members;
  PlotNumbers without;
  PlotNumbers all;
  for (std::size_t i = 0; i < plots.trees.size(); ++i) {
    const bool has_stratum = !stratum_of_plot.empty() && !stratum_of_plot[i].empty();
    if (has_stratum) members[stratum_of_plot[i]].push_back(i);
    if (!has_stratum && !stratum_of_plot.empty()) without.push_back(i);
    if (has_stratum || stratum_areas_ha.empty()) all.push_back(i);
  }
  std::set<std::string> names;
  for (const auto& [name, numbers] : members) names.insert(name);
  check_stratum_sizes(names, stratum_areas_ha);
  if (stratum_areas_ha.empty() && (settings.are_posterior || settings.is_finite)) {
    throw UsageError(
        "standard errors of this kind need the areas of strata: `stratum` and "
        "`stratum_areas`, or stratum and stratum_area in the table of `plots`",
        {.column = settings.is_finite ? "`finite_population`" : "`post_stratified`"});
  }
  if (settings.is_finite && are_weights) {
    throw UsageError("a finite population needs the areas of strata instead of their weights",
                     {.column = "`finite_population`"});
  }
  const Estimator estimator(plots);
  std::vector<StratumFigures> result;
  SizedStrata sized{.are_posterior = settings.are_posterior};
  for (const auto& [name, numbers] : members) {
    const auto unit = settings.unit_of_stratum.find(name);
    SizedStratum stratum{.plots = numbers,
                         .unit = unit == settings.unit_of_stratum.end() ? "" : unit->second};
    const auto area = stratum_areas_ha.find(name);
    if (area != stratum_areas_ha.end()) stratum.size = area->second;
    if (settings.is_finite) stratum.covered = estimator.covered(numbers, stratum.size, name);
    result.push_back(estimator.of_plots(stratum, name));
    if (area == stratum_areas_ha.end()) continue;
    if (!are_weights) estimator.add_totals(stratum, result.back());
    sized.list.push_back(std::move(stratum));
  }
  StratumFigures total = estimator.of_plots({.plots = all}, "");
  total.kind = StratumFigures::Kind::kAll;
  if (!stratum_areas_ha.empty()) estimator.combine(sized, are_weights, total);
  if (!without.empty()) {
    StratumFigures& others = result.emplace_back(estimator.of_plots({.plots = without}, ""));
    others.kind = StratumFigures::Kind::kWithout;
  }
  result.push_back(std::move(total));
  for (StratumFigures& figures : result) forget_unknown(figures);
  return result;
}

}  // namespace silvafit::stand
