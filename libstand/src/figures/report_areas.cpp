// SPDX-License-Identifier: MIT
// The areas of a stand report: which there are, and whether they can be right.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "figures/report_maker.hpp"
#include "sampling/plot_areas.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {

std::vector<SampledArea> ReportMaker::find_areas(const Inventory& inventory) {
  if (sample_ != nullptr) return sample_->areas;
  refuse_unused_factors(inventory);
  if (options_.without_areas) return plots_of_unknown_area(inventory);
  const std::vector<NamedWindow>& given = options_.units.windows;
  if (options_.plot_area_m2 && !given.empty()) {
    throw UsageError("use either `plot_area` or windows (`window`, `circle`), not both",
                     {.column = "`plot_area`"});
  }
  offered_ = offer_of_area_column(inventory);
  if (options_.plot_area_m2) {
    std::vector<SampledArea> areas = sampled_areas(inventory, *options_.plot_area_m2);
    // Plots whose trees lack a dbh have no tree to count, and are not empty.
    std::set<std::string> known;
    for (const SampledArea& area : areas) known.insert(area.name);
    for (const std::string& plot : inventory.plot.levels()) {
      if (!known.contains(plot)) areas.push_back({.name = plot});
    }
    std::ranges::move(take_unknown_plots(inventory, false, areas),
                      std::back_inserter(plots_left_out_));
    add_empty_plots(inventory, areas);
    return areas;
  }
  if (!inventory.has_coordinates()) {
    throw UsageError(
        fmt::format("the area is unknown, because the inventory has no positions; give "
                    "the area of a plot in m2 with `plot_area`{}",
                    offered_),
        {.file = inventory.file});
  }
  const PlotWindows windows = plot_windows(inventory, given, options_.units.scope);
  is_hull_ = windows.is_assumed;
  count_trees_without_window(inventory, windows);
  std::vector<SampledArea> areas =
      sampled_areas(inventory, windows, is_part_ ? std::vector<NamedWindow>() : given);
  std::ranges::move(take_unknown_plots(inventory, true, areas),
                    std::back_inserter(plots_left_out_));
  for (SampledArea& area : areas) {
    // The plot has the window of the stand, in which other parts have plots, too.
    const bool is_of_stand = is_part_ && !is_only_plot_ && !given.empty() &&
                             std::ranges::none_of(given, [&area](const NamedWindow& window) {
                               return window.plot == area.name || window.plot == kEveryPlot;
                             });
    if (is_of_stand) area.name.clear();
  }
  add_empty_plots(inventory, areas);
  return areas;
}

/// Plots without a living tree, and those of the table of plots without a row: they have an area
/// where one area or window is that of every plot.
void ReportMaker::add_empty_plots(const Inventory& inventory, std::vector<SampledArea>& areas) {
  const auto& windows = options_.units.windows;
  const auto every = std::ranges::find(windows, kEveryPlot, &NamedWindow::plot);
  const bool has_window = every != windows.end();
  const double area_m2 = area_of_every_plot_m2(options_.plot_area_m2, windows);
  std::set<std::string> known(inventory.plots_left_out.begin(), inventory.plots_left_out.end());
  known.insert(plots_left_out_.begin(), plots_left_out_.end());
  known.insert(inventory.plot.levels().begin(), inventory.plot.levels().end());
  for (const SampledArea& area : areas) known.insert(area.name);
  const auto add = [&](const std::string& plot) {
    if (!known.insert(plot).second) return false;
    SampledArea area{.name = plot, .area_m2 = area_m2};
    if (has_window) area.window = every->window;
    areas.push_back(std::move(area));
    return true;
  };
  if (area_m2 > 0.0) {
    for (const std::string& plot : inventory.plots_without_trees) add(plot);
  }
  if (!options_.design.plots) return;
  for (const PlotRecord& record : options_.design.plots->plots) {
    if (area_m2 > 0.0 ? add(record.plot) : known.insert(record.plot).second) {
      (area_m2 > 0.0 ? plots_of_table_without_trees_ : plots_of_table_without_window_)
          .push_back(record.plot);
    }
  }
  check_table_beside_areas(*options_.design.plots, areas);
}

/// Their trees are neither counted nor outside a window.
void ReportMaker::count_trees_without_window(const Inventory& inventory,
                                             const PlotWindows& windows) {
  if (windows.plots_without_window.empty()) return;
  plots_without_window_count_ += windows.plots_without_window.size();
  plots_without_window_.add(windows.plots_without_window);
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    const bool is_counted = !inventory.is_neighbor_only(tree) &&
                            !std::isnan(inventory.dbh_cm[tree]) && !std::isnan(inventory.x[tree]) &&
                            !std::isnan(inventory.y[tree]);
    if (is_counted && windows.window_of(inventory, tree) == nullptr) ++without_window_;
  }
}

/// Areas in the order in which they come if the file is read in parts; without rows last.
void ReportMaker::sort_areas(const Inventory& inventory, std::vector<SampledArea>& areas) {
  if (inventory.plot_lines.empty()) return;
  std::ranges::stable_sort(areas, {}, [&](const SampledArea& area) {
    const std::uint32_t code = inventory.plot.code_of(area.name);
    return code < inventory.plot_lines.size() ? inventory.plot_lines[code]
                                              : data::TextColumn::kMissingCode;
  });
}

void ReportMaker::count_trees_left_out(const Inventory& inventory,
                                       const std::vector<SampledArea>& areas) {
  std::vector<char> is_in_area(inventory.size(), 0);
  for (const SampledArea& area : areas) {
    for (const std::size_t tree : area.trees) is_in_area[tree] = 1;
    if (area.trees.empty()) ++empty_;
  }
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    // Notes of the inventory are about those without dbh, and the dead ones.
    const bool is_noted = inventory.is_neighbor_only(tree) || std::isnan(inventory.dbh_cm[tree]);
    if (is_in_area[tree] != 0 || is_noted) continue;
    const bool has_position = inventory.has_coordinates() && !std::isnan(inventory.x[tree]) &&
                              !std::isnan(inventory.y[tree]);
    ++(has_position ? outside_ : without_position_);
  }
}

/// An area that is given cannot be smaller than the hull of the trees on it.
void ReportMaker::compare_with_hull(const Inventory& inventory, const SampledArea& area) {
  const bool is_whole = sample_ == nullptr || sample_->represented.empty();
  if (area.window || !area.has_area || !is_whole) return;
  if (!inventory.has_coordinates() || inventory.is_placed_by_subplots) return;
  std::vector<Point> points;
  for (const std::size_t tree : area.trees) {
    const Point point{inventory.x[tree], inventory.y[tree]};
    if (std::isfinite(point.x) && std::isfinite(point.y)) points.push_back(point);
  }
  const std::optional<Window> hull = Window::convex_hull(points);
  if (!hull) return;
  // The hull of ten points anywhere on an area covers some 40 % of it (Efron 1965, Biometrika 52:
  // 331-343), and less than a tenth nearly never.
  constexpr std::size_t kEnough = 10;
  constexpr double kLeastShare = 0.1;
  const bool is_smaller = hull->area_m2() > area.area_m2;
  const bool is_larger = points.size() >= kEnough && hull->area_m2() < kLeastShare * area.area_m2;
  if (!is_smaller && !is_larger) return;
  HullDifference& difference = is_smaller ? smaller_than_hull_ : larger_than_hull_;
  if (difference.plots++ > 0) return;
  difference.first =
      fmt::format("plot {}: {:.6g} m2, hull {:.6g} m2", area.name, area.area_m2, hull->area_m2());
}

/// Plots without trees are counted, too.
void ReportMaker::add_plots_without_rows() {
  if (options_.plot_area_m2) return;
  std::vector<SampledArea> areas;
  for (const NamedWindow& window : options_.units.windows) {
    if (!window.plot || !windows_without_rows_.contains(*window.plot)) continue;
    if (std::ranges::find(plots_left_out_, *window.plot) != plots_left_out_.end()) continue;
    areas.push_back(
        {.name = *window.plot, .area_m2 = window.window.area_m2(), .window = window.window});
  }
  empty_ += areas.size();
  require_trees_of_strata(areas, without_rows_.file);
  add_figures(without_rows_, std::move(areas), {});
}

void ReportMaker::check_density(const std::string& file) const {
  if (options_.trust_units) return;
  const Place place{.file = file, .column = options_.plot_area_m2 ? "`plot_area`" : "area"};
  check_density_is_possible(report_.all.basal_area_m2_per_ha, place);
  if (sample_ != nullptr) return;
  for (const AreaReport& plot : report_.areas) {
    const auto trees = static_cast<double>(plot.figures.trees);
    const double basal_area_m2 =
        plot.figures.basal_area_m2_per_ha * plot.area.area_m2 / kSquareMetersPerHectare;
    check_plot_density(plot.area.name, trees, basal_area_m2, plot.area.area_m2, place);
  }
}

}  // namespace silvafit::stand
