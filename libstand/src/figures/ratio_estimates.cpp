// SPDX-License-Identifier: MIT
#include "figures/ratio_estimates.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {

PlotTotals totals_of(const Inventory& inventory,
                     const std::vector<SampledArea>& areas,
                     const TreeValue& value) {
  PlotTotals totals;
  for (const SampledArea& area : areas) {
    double sum = 0.0;
    for (const std::size_t tree : area.trees) {
      const double own = value(tree);
      if (!std::isnan(own)) sum += inventory.trees_represented(tree) * own;
    }
    totals.push_back(sum);
  }
  return totals;
}

Mean ratio_of_sums(const PlotTotals& values, const PlotTotals& sizes, const SizedStratum& stratum) {
  const PlotNumbers& plots = stratum.plots;
  const auto n = static_cast<double>(plots.size());
  double value = 0.0;
  double size = 0.0;
  for (const std::size_t plot : plots) {
    value += values[plot];
    size += sizes[plot];
  }
  Mean ratio{.value = value / size, .standard_error = data::kMissing};
  const auto has_size = [&sizes](std::size_t plot) { return sizes[plot] != 0.0; };
  if (std::ranges::count_if(plots, has_size) < 2) return ratio;
  double squares = 0.0;
  for (const std::size_t plot : plots) {
    const double deviation = values[plot] - ratio.value * sizes[plot];
    squares += deviation * deviation;
  }
  ratio.standard_error =
      std::sqrt((1.0 - stratum.covered) * squares / (n * (n - 1.0))) / (size / n);
  return ratio;
}

const PlotTotals& areas_of_strata(const PlotTotals& in_population, const PlotTotals& whole) {
  const bool has_outside = std::ranges::find(in_population, 0.0) != in_population.end();
  return has_outside ? whole : in_population;
}

Mean total_of(const PlotTotals& values, const PlotTotals& areas_ha, const SizedStrata& strata) {
  /// Area and number of plots of an estimation unit.
  struct Unit {
    double size = 0.0;
    double plots = 0.0;
  };
  std::map<std::string, Unit> units;
  for (const SizedStratum& stratum : strata.list) {
    if (stratum.size == 0.0) continue;
    Unit& unit = units[stratum.unit];
    unit.size += stratum.size;
    unit.plots += static_cast<double>(stratum.plots.size());
  }
  double total = 0.0;
  double variance = 0.0;
  for (const SizedStratum& stratum : strata.list) {
    if (stratum.size == 0.0) continue;
    const Mean mean = ratio_of_sums(values, areas_ha, stratum);
    total += stratum.size * mean.value;
    if (strata.are_posterior) {
      const Unit& unit = units[stratum.unit];
      const double weight = stratum.size / unit.size;
      const double of_plot =
          static_cast<double>(stratum.plots.size()) * mean.standard_error * mean.standard_error;
      variance += unit.size * unit.size * of_plot *
                  (weight / unit.plots + (1.0 - weight) / (unit.plots * unit.plots));
    } else {
      variance += std::pow(stratum.size * mean.standard_error, 2);
    }
  }
  return {.value = total, .standard_error = std::sqrt(variance)};
}

Mean combined_ratio(const PlotTotals& values,
                    const PlotTotals& counts,
                    const PlotTotals& areas_ha,
                    const SizedStrata& strata) {
  const double count = total_of(counts, areas_ha, strata).value;
  if (!(count > 0.0)) return {.value = data::kMissing, .standard_error = data::kMissing};
  const double ratio = total_of(values, areas_ha, strata).value / count;
  // A ratio that one plot has alone does not vary.
  const auto has_count = [](double value) { return value != 0.0; };
  if (std::ranges::count_if(counts, has_count) < 2) {
    return {.value = ratio, .standard_error = data::kMissing};
  }
  PlotTotals residuals;
  for (std::size_t i = 0; i < values.size(); ++i)
    residuals.push_back(values[i] - ratio * counts[i]);
  return {.value = ratio,
          .standard_error = total_of(residuals, areas_ha, strata).standard_error / count};
}

Estimate estimate_of(const Mean& per_ha) {
  return {.per_ha = per_ha.value,
          .standard_error = per_ha.standard_error,
          .total = data::kMissing,
          .total_standard_error = data::kMissing};
}

void add_total(Estimate& estimate,
               const PlotTotals& values,
               const PlotTotals& of_strata,
               const SizedStratum& stratum) {
  const Mean total = total_of(values, of_strata, {.list = {stratum}});
  estimate.total = total.value;
  estimate.total_standard_error = total.standard_error;
}

Estimate over_strata(const PlotTotals& values,
                     const PlotTotals& areas_ha,
                     const PlotTotals& of_strata,
                     const SizedStrata& strata,
                     bool are_weights) {
  Estimate estimate = estimate_of(combined_ratio(values, areas_ha, of_strata, strata));
  if (are_weights) return estimate;
  const Mean total = total_of(values, of_strata, strata);
  estimate.total = total.value;
  estimate.total_standard_error = total.standard_error;
  return estimate;
}

void check_stratum_sizes(const std::set<std::string>& names,
                         const std::map<std::string, double>& sizes) {
  for (const auto& [name, area] : sizes) {
    if (!names.contains(name)) {
      throw UsageError(
          fmt::format("unknown stratum '{}'; available: {}", name, fmt::join(names, ", ")),
          {.column = "`stratum_areas`"});
    }
    if (!(area >= 0.0) || std::isinf(area)) {
      throw UsageError(
          fmt::format("the area of stratum '{}', {} ha, must be 0 or more", name, area),
          {.column = "`stratum_areas`"});
    }
  }
  const auto is_zero = [](const auto& size) { return size.second == 0.0; };
  if (!sizes.empty() && std::ranges::all_of(sizes, is_zero)) {
    throw UsageError("the areas of all strata are 0", {.column = "`stratum_areas`"});
  }
  if (sizes.empty() || sizes.size() == names.size()) return;
  for (const std::string& name : names) {
    if (!sizes.contains(name)) {
      throw UsageError(fmt::format("no area for stratum '{}'; give it with `stratum_areas`", name),
                       {.column = "`stratum_areas`"});
    }
  }
}

}  // namespace silvafit::stand
