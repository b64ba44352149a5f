// SPDX-License-Identifier: MIT
// Design-based estimates by stratum.
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "density_indices.hpp"
#include "ratio_estimates.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {
namespace {

/// The totals of plots that all estimates need.
class Estimator {
 public:
  Estimator(const Inventory& inventory, const std::vector<SampledArea>& areas);

  StratumFigures of_plots(const PlotNumbers& plots, std::string name) const;
  void combine(const std::vector<SizedStratum>& strata,
               bool are_weights,
               StratumFigures& result) const;

 private:
  void add_means(const std::vector<SizedStratum>& strata, StratumFigures& result) const;

  const std::vector<SampledArea>& areas_;
  PlotTotals areas_ha_{};
  PlotTotals stems_{};
  PlotTotals basal_areas_m2_{};
  std::vector<PlotTotals> quantities_{};
  PlotTotals heights_m_{};
  PlotTotals stems_with_height_{};
};

Estimator::Estimator(const Inventory& inventory, const std::vector<SampledArea>& areas)
    : areas_(areas) {
  const auto height = [&inventory](std::size_t tree) {
    return inventory.h_m.empty() ? data::kMissing : inventory.h_m[tree];
  };
  for (const SampledArea& area : areas) areas_ha_.push_back(area.area_m2 / kSquareMetersPerHectare);
  stems_ = totals_of(inventory, areas, [](std::size_t) { return 1.0; });
  basal_areas_m2_ = totals_of(inventory, areas, [&inventory](std::size_t tree) {
    return basal_area_m2(inventory.dbh_cm[tree]);
  });
  for (const TreeQuantity& quantity : inventory.quantities) {
    quantities_.push_back(totals_of(
        inventory, areas, [&quantity](std::size_t tree) { return quantity.values[tree]; }));
  }
  heights_m_ = totals_of(inventory, areas, height);
  stems_with_height_ = totals_of(inventory, areas, [&height](std::size_t tree) {
    return std::isnan(height(tree)) ? data::kMissing : 1.0;
  });
}

void Estimator::add_means(const std::vector<SizedStratum>& strata, StratumFigures& result) const {
  result.mean_height_m = combined_ratio(heights_m_, stems_with_height_, areas_ha_, strata);
  const Mean mean_basal_m2 = combined_ratio(basal_areas_m2_, stems_, areas_ha_, strata);
  const double diameter_m = std::sqrt(4.0 / std::numbers::pi * mean_basal_m2.value);
  constexpr double kCentimetersPerMeter = 100.0;
  // d(dg)/d(g) = dg / (2 g)
  result.quadratic_mean_dbh_cm = {.value = kCentimetersPerMeter * diameter_m,
                                  .standard_error = kCentimetersPerMeter * diameter_m *
                                                    mean_basal_m2.standard_error /
                                                    (2.0 * mean_basal_m2.value)};
}

StratumFigures Estimator::of_plots(const PlotNumbers& plots, std::string name) const {
  StratumFigures result{.name = std::move(name), .plots = plots.size(), .area_ha = data::kMissing};
  for (const std::size_t plot : plots) {
    result.trees += areas_[plot].trees.size();
    result.sampled_ha += areas_[plot].has_area ? areas_ha_[plot] : data::kMissing;
  }
  result.stems = estimate_of(ratio_of_sums(stems_, areas_ha_, plots));
  result.basal_area_m2 = estimate_of(ratio_of_sums(basal_areas_m2_, areas_ha_, plots));
  for (const PlotTotals& totals : quantities_) {
    result.quantities.push_back(estimate_of(ratio_of_sums(totals, areas_ha_, plots)));
  }
  add_means({{.plots = plots}}, result);
  return result;
}

void Estimator::combine(const std::vector<SizedStratum>& strata,
                        bool are_weights,
                        StratumFigures& result) const {
  double size = 0.0;
  for (const SizedStratum& stratum : strata) size += stratum.size;
  result.area_ha = are_weights ? data::kMissing : size;
  result.stems = over_strata(total_of(stems_, areas_ha_, strata), size, are_weights);
  result.basal_area_m2 =
      over_strata(total_of(basal_areas_m2_, areas_ha_, strata), size, are_weights);
  result.quantities.clear();
  for (const PlotTotals& totals : quantities_) {
    result.quantities.push_back(
        over_strata(total_of(totals, areas_ha_, strata), size, are_weights));
  }
  add_means(strata, result);
}

}  // namespace

std::vector<StratumFigures> stratum_figures(const Inventory& inventory,
                                            const std::vector<SampledArea>& areas,
                                            const std::vector<std::string>& stratum_of_area,
                                            const std::map<std::string, double>& stratum_areas_ha,
                                            bool are_weights) {
  std::map<std::string, PlotNumbers> members;
  PlotNumbers without;
  PlotNumbers all;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const bool has_stratum = !stratum_of_area.empty() && !stratum_of_area[i].empty();
    if (has_stratum) members[stratum_of_area[i]].push_back(i);
    if (!has_stratum && !stratum_of_area.empty()) without.push_back(i);
    if (has_stratum || stratum_areas_ha.empty()) all.push_back(i);
  }
  std::set<std::string> names;
  for (const auto& [name, plots] : members) names.insert(name);
  check_stratum_sizes(names, stratum_areas_ha);
  const Estimator estimator(inventory, areas);
  std::vector<StratumFigures> result;
  std::vector<SizedStratum> sized;
  for (const auto& [name, plots] : members) {
    StratumFigures& stratum = result.emplace_back(estimator.of_plots(plots, name));
    const auto area = stratum_areas_ha.find(name);
    if (area == stratum_areas_ha.end()) continue;
    sized.push_back({.plots = plots, .size = area->second});
    if (are_weights) continue;
    stratum.area_ha = area->second;
    add_total(stratum.stems, stratum.area_ha);
    add_total(stratum.basal_area_m2, stratum.area_ha);
    for (Estimate& quantity : stratum.quantities) add_total(quantity, stratum.area_ha);
  }
  StratumFigures total = estimator.of_plots(all, "");
  total.kind = StratumFigures::Kind::kAll;
  if (!stratum_areas_ha.empty()) estimator.combine(sized, are_weights, total);
  if (!without.empty()) {
    StratumFigures& others = result.emplace_back(estimator.of_plots(without, ""));
    others.kind = StratumFigures::Kind::kWithout;
  }
  result.push_back(std::move(total));
  return result;
}

}  // namespace silvafit::stand
