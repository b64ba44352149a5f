// SPDX-License-Identifier: MIT
#include "silvafit/stand/stand_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "density_indices.hpp"
#include "moments.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

constexpr double kMostClasses = 1e4;

/// Sets the mean height of the thickest trees.
void set_dominant_height(const Inventory& inventory,
                         std::span<const std::size_t> trees,
                         double wanted,
                         StandFigures& figures) {
  figures.dominant_height_m = data::kMissing;
  if (inventory.h_m.empty() || trees.empty() || std::isnan(wanted)) return;
  std::vector<std::size_t> order(trees.begin(), trees.end());
  // Missing heights last among equals.
  const auto height = [&inventory](std::size_t tree) {
    return std::isnan(inventory.h_m[tree]) ? 0.0 : inventory.h_m[tree];
  };
  const auto count =
      std::clamp<std::size_t>(static_cast<std::size_t>(std::llround(wanted)), 1, order.size());
  std::partial_sort(order.begin(),
                    order.begin() + static_cast<std::ptrdiff_t>(count),
                    order.end(),
                    [&](std::size_t left, std::size_t right) {
                      return std::pair(inventory.dbh_cm[left], height(left)) >
                             std::pair(inventory.dbh_cm[right], height(right));
                    });
  Moments heights;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isnan(inventory.h_m[order[i]])) {
      ++figures.dominant_trees_without_height;
    } else {
      heights.add(inventory.h_m[order[i]]);
    }
  }
  figures.dominant_trees = count;
  figures.dominant_height_m = heights.mean();
}

/// The values of each plot of a stratum.
struct Sample {
  std::vector<double> counted{};
  std::vector<double> area_ha{};
};

Estimate ratio_estimate(const Sample& sample) {
  const auto n = static_cast<double>(sample.counted.size());
  double counted = 0.0;
  double area = 0.0;
  for (std::size_t i = 0; i < sample.counted.size(); ++i) {
    counted += sample.counted[i];
    area += sample.area_ha[i];
  }
  Estimate estimate{.per_ha = counted / area,
                    .standard_error = data::kMissing,
                    .total = data::kMissing,
                    .total_standard_error = data::kMissing};
  if (sample.counted.size() < 2) return estimate;
  double squares = 0.0;
  for (std::size_t i = 0; i < sample.counted.size(); ++i) {
    const double deviation = sample.counted[i] - estimate.per_ha * sample.area_ha[i];
    squares += deviation * deviation;
  }
  estimate.standard_error = std::sqrt(squares / (n * (n - 1.0))) / (area / n);
  return estimate;
}

void add_total(Estimate& estimate, double area_ha) {
  estimate.total = estimate.per_ha * area_ha;
  estimate.total_standard_error = estimate.standard_error * area_ha;
}

/// Sum over independent strata.
Estimate stratified(const std::vector<StratumFigures>& strata, Estimate StratumFigures::*what) {
  double area = 0.0;
  double total = 0.0;
  double variance = 0.0;
  for (const StratumFigures& stratum : strata) {
    const Estimate& part = stratum.*what;
    area += stratum.area_ha;
    total += part.total;
    variance += part.total_standard_error * part.total_standard_error;
  }
  return {.per_ha = total / area,
          .standard_error = std::sqrt(variance) / area,
          .total = total,
          .total_standard_error = std::sqrt(variance)};
}

StratumFigures figures_of_plots(const Inventory& inventory,
                                const std::vector<SampledArea>& areas,
                                const std::vector<std::size_t>& members,
                                std::string name) {
  StratumFigures result{
      .name = std::move(name), .plots = members.size(), .area_ha = data::kMissing};
  Sample stems;
  Sample basal_areas;
  for (const std::size_t member : members) {
    const SampledArea& area = areas[member];
    const double hectares = area.area_m2 / kSquareMetersPerHectare;
    double basal_m2 = 0.0;
    for (const std::size_t tree : area.trees) basal_m2 += basal_area_m2(inventory.dbh_cm[tree]);
    result.trees += area.trees.size();
    result.sampled_ha += hectares;
    stems.counted.push_back(static_cast<double>(area.trees.size()));
    stems.area_ha.push_back(hectares);
    basal_areas.counted.push_back(basal_m2);
    basal_areas.area_ha.push_back(hectares);
  }
  result.stems = ratio_estimate(stems);
  result.basal_area_m2 = ratio_estimate(basal_areas);
  return result;
}

void check_stratum_areas(const std::set<std::string>& names,
                         const std::map<std::string, double>& areas_ha) {
  for (const auto& [name, area] : areas_ha) {
    if (!names.contains(name)) {
      throw UsageError(
          fmt::format("unknown stratum '{}'; available: {}", name, fmt::join(names, ", ")),
          {.column = "--stratum-area"});
    }
    if (!(area > 0.0) || std::isinf(area)) {
      throw UsageError(fmt::format("the area of stratum '{}', {} ha, must be above 0", name, area),
                       {.column = "--stratum-area"});
    }
  }
  if (areas_ha.empty() || areas_ha.size() == names.size()) return;
  for (const std::string& name : names) {
    if (!areas_ha.contains(name)) {
      throw UsageError(fmt::format("no area for stratum '{}'; give it with --stratum-area", name),
                       {.column = "--stratum-area"});
    }
  }
}

}  // namespace

std::vector<SampledArea> sampled_areas(const Inventory& inventory,
                                       const PlotWindows& windows,
                                       const std::vector<NamedWindow>& given) {
  std::vector<SampledArea> areas;
  for (const Domain& domain : windows.domains) {
    areas.push_back(
        {.name = domain.name, .area_m2 = domain.window.area_m2(), .window = domain.window});
  }
  const std::vector<char> inside = trees_inside(inventory, windows);
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    if (inside[tree] == 0 || inventory.is_neighbor_only(tree)) continue;
    areas[*windows.domain_of_plot[inventory.plot.code(tree)]].trees.push_back(tree);
  }
  for (const NamedWindow& window : given) {
    if (!window.plot || *window.plot == kEveryPlot) continue;
    if (inventory.plot.code_of(*window.plot) != data::TextColumn::kMissingCode) continue;
    const auto& left_out = inventory.plots_left_out;
    if (std::ranges::find(left_out, *window.plot) != left_out.end()) continue;
    areas.push_back(
        {.name = *window.plot, .area_m2 = window.window.area_m2(), .window = window.window});
  }
  return areas;
}

std::vector<SampledArea> sampled_areas(const Inventory& inventory, double plot_area_m2) {
  if (!(plot_area_m2 > 0.0) || std::isinf(plot_area_m2)) {
    throw UsageError(fmt::format("an area of {} m2 must be above 0", plot_area_m2),
                     {.column = "--plot-area"});
  }
  std::vector<SampledArea> areas = plots_of_unknown_area(inventory);
  for (SampledArea& area : areas) area.area_m2 = plot_area_m2;
  return areas;
}

std::vector<SampledArea> plots_of_unknown_area(const Inventory& inventory) {
  std::vector<SampledArea> areas;
  for (const std::string& plot : inventory.plot.levels()) {
    areas.push_back({.name = plot, .area_m2 = data::kMissing});
  }
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    if (inventory.is_neighbor_only(tree)) continue;
    areas[inventory.plot.code(tree)].trees.push_back(tree);
  }
  std::erase_if(areas, [](const SampledArea& area) { return area.trees.empty(); });
  return areas;
}

StandFigures stand_figures(const Inventory& inventory,
                           std::span<const std::size_t> trees,
                           double area_m2,
                           double dominant_trees_per_ha) {
  StandFigures figures{.trees = trees.size(), .area_ha = area_m2 / kSquareMetersPerHectare};
  Moments dbh;
  Moments heights;
  double basal_m2 = 0.0;
  double basal_with_height_m2 = 0.0;
  double basal_times_height = 0.0;
  double crowns_m2 = 0.0;
  for (const std::size_t tree : trees) {
    const double own_m2 = basal_area_m2(inventory.dbh_cm[tree]);
    basal_m2 += own_m2;
    dbh.add(inventory.dbh_cm[tree]);
    if (!inventory.h_m.empty() && !std::isnan(inventory.h_m[tree])) {
      heights.add(inventory.h_m[tree]);
      basal_with_height_m2 += own_m2;
      basal_times_height += own_m2 * inventory.h_m[tree];
    }
    if (inventory.cw_m.empty() || std::isnan(inventory.cw_m[tree])) {
      ++figures.trees_without_crown_width;
    } else {
      crowns_m2 += std::numbers::pi / 4.0 * inventory.cw_m[tree] * inventory.cw_m[tree];
    }
  }
  const auto count = static_cast<double>(trees.size());
  figures.stems_per_ha = count / figures.area_ha;
  figures.basal_area_m2_per_ha = basal_m2 / figures.area_ha;
  figures.mean_dbh_cm = dbh.mean();
  figures.sd_dbh_cm = dbh.standard_deviation();
  figures.quadratic_mean_dbh_cm =
      trees.empty() ? data::kMissing : 200.0 * std::sqrt(basal_m2 / count / std::numbers::pi);
  figures.mean_height_m = heights.mean();
  figures.sd_height_m = heights.standard_deviation();
  figures.lorey_height_m =
      basal_with_height_m2 > 0.0 ? basal_times_height / basal_with_height_m2 : data::kMissing;
  set_dominant_height(inventory, trees, dominant_trees_per_ha * figures.area_ha, figures);
  const bool has_crowns =
      trees.empty() ? !inventory.cw_m.empty() : figures.trees_without_crown_width < trees.size();
  figures.crown_cover_percent = has_crowns ? 100.0 * crowns_m2 / area_m2 : data::kMissing;
  return figures;
}

std::string note_on_crown_cover(const StandFigures& figures) {
  const std::size_t without = figures.trees_without_crown_width;
  if (without == 0 || without == figures.trees) return {};
  return fmt::format(
      "{} of {} trees {} no crown width and {} not included in the crown cover, which is therefore "
      "too small",
      without,
      figures.trees,
      without == 1 ? "has" : "have",
      without == 1 ? "is" : "are");
}

std::vector<DiameterClass> diameter_distribution(const Inventory& inventory,
                                                 std::span<const std::size_t> trees,
                                                 double area_m2,
                                                 double width_cm) {
  if (!(width_cm > 0.0) || std::isinf(width_cm)) {
    throw UsageError(fmt::format("the width of a diameter class, {} cm, must be above 0", width_cm),
                     {.column = "--class-width"});
  }
  std::vector<DiameterClass> classes;
  if (trees.empty()) return classes;
  // A diameter on the class limit belongs to the upper class; the tolerance covers rounding.
  const auto class_of = [width_cm](double dbh_cm) { return std::floor(dbh_cm / width_cm + 1e-9); };
  double lowest = class_of(inventory.dbh_cm[trees.front()]);
  double highest = lowest;
  for (const std::size_t tree : trees) {
    lowest = std::min(lowest, class_of(inventory.dbh_cm[tree]));
    highest = std::max(highest, class_of(inventory.dbh_cm[tree]));
  }
  // Class numbers are integers, and each is one more than the previous one, below 2^53.
  if (highest - lowest >= kMostClasses || highest >= 0x1p53) {
    throw UsageError(
        fmt::format("diameter classes of {} cm are too narrow for these trees", width_cm),
        {.column = "--class-width"});
  }
  for (double number = lowest; number <= highest; number += 1.0) {
    classes.push_back({.low_cm = number * width_cm, .high_cm = (number + 1.0) * width_cm});
  }
  const double hectares = area_m2 / kSquareMetersPerHectare;
  for (const std::size_t tree : trees) {
    const double number = class_of(inventory.dbh_cm[tree]) - lowest;
    DiameterClass& own = classes[static_cast<std::size_t>(number)];
    ++own.trees;
    own.stems_per_ha += 1.0 / hectares;
    own.basal_area_m2_per_ha += basal_area_m2(inventory.dbh_cm[tree]) / hectares;
  }
  return classes;
}

std::vector<StratumFigures> stratum_figures(const Inventory& inventory,
                                            const std::vector<SampledArea>& areas,
                                            const std::vector<std::string>& stratum_of_area,
                                            const std::map<std::string, double>& stratum_areas_ha) {
  std::map<std::string, std::vector<std::size_t>> members;
  std::vector<std::size_t> without;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const bool has_stratum = !stratum_of_area.empty() && !stratum_of_area[i].empty();
    if (has_stratum) members[stratum_of_area[i]].push_back(i);
    if (!has_stratum && !stratum_of_area.empty()) without.push_back(i);
    if (has_stratum || stratum_areas_ha.empty()) all.push_back(i);
  }
  std::set<std::string> names;
  for (const auto& [name, plots] : members) names.insert(name);
  check_stratum_areas(names, stratum_areas_ha);
  std::vector<StratumFigures> result;
  for (const auto& [name, plots] : members) {
    StratumFigures& stratum = result.emplace_back(figures_of_plots(inventory, areas, plots, name));
    const auto area = stratum_areas_ha.find(name);
    if (area == stratum_areas_ha.end()) continue;
    stratum.area_ha = area->second;
    add_total(stratum.stems, stratum.area_ha);
    add_total(stratum.basal_area_m2, stratum.area_ha);
  }
  StratumFigures total = figures_of_plots(inventory, areas, all, "");
  total.kind = StratumFigures::Kind::kAll;
  if (!stratum_areas_ha.empty()) {
    total.area_ha = 0.0;
    for (const auto& [name, area] : stratum_areas_ha) total.area_ha += area;
    total.stems = stratified(result, &StratumFigures::stems);
    total.basal_area_m2 = stratified(result, &StratumFigures::basal_area_m2);
  }
  if (!without.empty()) {
    StratumFigures& others = result.emplace_back(figures_of_plots(inventory, areas, without, ""));
    others.kind = StratumFigures::Kind::kWithout;
  }
  result.push_back(std::move(total));
  return result;
}

}  // namespace silvafit::stand
