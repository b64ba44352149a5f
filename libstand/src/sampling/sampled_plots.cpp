// SPDX-License-Identifier: MIT
// Structural units and strata of sampled plots.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/sampling_design.hpp"

namespace silvafit::stand {

Inventory with_represented(const Inventory& inventory, const DesignedSample& sample) {
  Inventory result = inventory;
  result.represented = sample.represented;
  return result;
}

StructuralUnits structural_units_of_sample(const Inventory& inventory,
                                           const DesignedSample& sample,
                                           StructuralUnitOptions options) {
  if (!options.windows.empty()) {
    throw UsageError("the sampling design has circles of its own; omit `window` and `circle`",
                     {.column = "`window`"});
  }
  if (options.scope == SearchScope::kStand) {
    throw UsageError("neighbors of sampled plots are searched within each plot; omit `per=stand`",
                     {.column = "`per`"});
  }
  const bool has_hegyi =
      std::ranges::find(options.further, FurtherIndex::kHegyi) != options.further.end();
  if (has_hegyi && options.edge == EdgeCorrection::kBuffer) {
    options.buffer_m = std::max(options.buffer_m, options.competition_radius_m);
  }
  options.windows = sample.complete_circles;
  options.sampled = sample.areas;
  Inventory labeled = with_represented(inventory, sample);
  if (sample.subplot_labels) labeled.plot = *sample.subplot_labels;
  StructuralUnits units = structural_units(labeled, options);
  // Windows are found by the plots of the inventory, which has no subplots.
  if (sample.subplot_labels) units.windows = {};
  return units;
}

namespace {

/// The estimation unit of each stratum.
void find_units(const PlotTable& plots, DesignStrata& result) {
  for (const PlotRecord& record : plots.plots) {
    if (record.stratum.empty()) continue;
    const auto [unit, is_new] =
        result.unit_of_stratum.try_emplace(record.stratum, record.estimation_unit);
    if (is_new || unit->second == record.estimation_unit) continue;
    throw InputError(fmt::format("stratum '{}' is in the estimation unit '{}' here and in '{}' in "
                                 "another row; name strata differently in each unit",
                                 record.stratum,
                                 record.estimation_unit,
                                 unit->second),
                     {.file = plots.file,
                      .line = record.line,
                      .column = "estimation_unit",
                      .plot = record.plot});
  }
}

/// The area, or the weight, of each stratum.
void find_sizes(const PlotTable& plots, DesignStrata& result) {
  const auto size_of = [&result](const PlotRecord& record) {
    return result.are_weights ? record.stratum_weight : record.stratum_ha;
  };
  const auto has_area = [](const PlotRecord& record) { return !std::isnan(record.stratum_ha); };
  const auto has_weight = [](const PlotRecord& record) {
    return !std::isnan(record.stratum_weight);
  };
  result.are_weights =
      std::ranges::none_of(plots.plots, has_area) && std::ranges::any_of(plots.plots, has_weight);
  for (const PlotRecord& record : plots.plots) {
    if (record.stratum.empty() || std::isnan(size_of(record))) continue;
    const auto [size, is_new] = result.sizes.try_emplace(record.stratum, size_of(record));
    if (is_new || size->second == size_of(record)) continue;
    throw InputError(fmt::format("stratum '{}' has {} here and {} in another row",
                                 record.stratum,
                                 size_of(record),
                                 size->second),
                     {.file = plots.file,
                      .line = record.line,
                      .column = result.are_weights ? "stratum_weight" : "stratum_area",
                      .plot = record.plot});
  }
}

}  // namespace

void refuse_two_strata(const std::string& column, const std::optional<PlotTable>& plots) {
  if (column.empty() || !plots || !plots->has_stratum) return;
  const auto has_size = [](const PlotRecord& record) {
    return !std::isnan(record.stratum_ha) || !std::isnan(record.stratum_weight);
  };
  if (std::ranges::none_of(plots->plots, has_size)) return;
  throw UsageError(
      fmt::format("the table of plots has strata with their areas or weights, which strata by the "
                  "column {} of the trees would not have; omit `stratum`, and name the column of "
                  "the table of plots with `plots_columns=stratum=COLUMN`",
                  column),
      {.file = plots->file, .column = "`stratum`"});
}

DesignStrata strata_of_plots(const PlotTable& plots,
                             const std::vector<SampledArea>& areas,
                             const std::map<std::string, double>& sizes_ha) {
  DesignStrata result;
  std::unordered_map<std::string, const PlotRecord*> by_name;
  for (const PlotRecord& record : plots.plots) {
    const PlotRecord& known = *by_name.try_emplace(record.plot, &record).first->second;
    if (known.stratum == record.stratum) continue;
    throw InputError(
        fmt::format("the plot belongs to two strata, '{}' and '{}'", known.stratum, record.stratum),
        {.file = plots.file, .line = record.line, .column = "stratum", .plot = record.plot});
  }
  std::vector<std::string> without;
  std::set<std::string> named;
  for (const SampledArea& area : areas) {
    const auto found = by_name.find(area.name);
    const std::string stratum = found == by_name.end() ? "" : found->second->stratum;
    if (stratum.empty() && named.insert(area.name).second) without.push_back(area.name);
    result.stratum_of_area.push_back(stratum);
  }
  find_units(plots, result);
  find_sizes(plots, result);
  if (!sizes_ha.empty()) {
    if (!result.sizes.empty() && (result.are_weights || result.sizes != sizes_ha)) {
      result.notes.emplace_back(
          "areas of strata are those of `stratum_areas`, not those of the table of plots");
    }
    result.sizes = sizes_ha;
    result.are_weights = false;
  }
  const auto is_outside = [](const SampledArea& area) { return area.area_m2 == 0.0; };
  if (!result.sizes.empty() && std::ranges::any_of(areas, is_outside)) {
    result.notes.push_back(
        fmt::format("{} of strata are taken as those of all land of which the plots are a sample, "
                    "because there "
                    "are plots with share 0; values per hectare are those of the population",
                    result.are_weights ? "weights" : "areas"));
  }
  if (!without.empty()) {
    result.notes.push_back(
        fmt::format("{} no stratum in the table of plots; {} values are in the row '(none)'{}: {}",
                    counted(without.size(), "plot has", "plots have"),
                    without.size() == 1 ? "its" : "their",
                    result.sizes.empty() ? "" : ", which the row of all strata does not include",
                    data::list_of(without)));
  }
  return result;
}

}  // namespace silvafit::stand
