// SPDX-License-Identifier: MIT
#include "silvafit/stand/plot_windows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string_view>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::stand {
namespace {

constexpr std::size_t kTreesPerWindowTask = 4096;
/// Trees within a strip this narrow are on one line, as in Window::convex_hull.
constexpr double kNarrowestPlotMeters = 1e-6;

bool has_position(const Inventory& inventory, std::size_t tree) {
  return !std::isnan(inventory.x[tree]) && !std::isnan(inventory.y[tree]);
}

/// The window around points; none if they have no area.
std::optional<Window> window_around(const std::vector<Point>& points, AssumedWindow assumed) {
  if (assumed == AssumedWindow::kConvexHull) return Window::convex_hull(points);
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point high{-low.x, -low.y};
  for (const Point& point : points) {
    low = {std::min(low.x, point.x), std::min(low.y, point.y)};
    high = {std::max(high.x, point.x), std::max(high.y, point.y)};
  }
  if (!(high.x - low.x > kNarrowestPlotMeters && high.y - low.y > kNarrowestPlotMeters))
    return std::nullopt;
  return Window::rectangle(low, high);
}

std::string_view shape_name(AssumedWindow assumed) {
  return assumed == AssumedWindow::kConvexHull ? "convex hull of" : "rectangle around";
}

void assume_stand(const Inventory& inventory, AssumedWindow assumed, PlotWindows& result) {
  std::vector<Point> points;
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if (has_position(inventory, i)) points.push_back({inventory.x[i], inventory.y[i]});
  }
  const std::optional<Window> window = window_around(points, assumed);
  if (!window) {
    result.notes.emplace_back("trees on one line have no convex hull, so there is no core tree");
    return;
  }
  result.notes.push_back(
      fmt::format("no window is given; the {} all trees is used, which is smaller than the stand: "
                  "x {} to {}, y {} to {}, {:.4g} ha",
                  shape_name(assumed),
                  window->low().x,
                  window->high().x,
                  window->low().y,
                  window->high().y,
                  window->area_m2() / 1e4));
  result.domains.push_back({.window = *window});
  std::ranges::fill(result.domain_of_plot, 0);
}

void assume_plots(const Inventory& inventory, AssumedWindow assumed, PlotWindows& result) {
  const std::vector<std::string>& names = inventory.plot.levels();
  std::vector<std::vector<Point>> points(names.size());
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if (!has_position(inventory, i)) continue;
    points[inventory.plot.code(i)].push_back({inventory.x[i], inventory.y[i]});
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (points[i].empty()) continue;
    if (const std::optional<Window> window = window_around(points[i], assumed)) {
      result.domain_of_plot[i] = result.domains.size();
      result.domains.push_back({.name = names[i], .window = *window});
    } else {
      result.plots_without_window.push_back(names[i]);
    }
  }
  result.notes.push_back(fmt::format(
      "no window is given; the {} the trees of each plot is used, which is smaller than the plot",
      shape_name(assumed)));
}

/// Finds the given window of each plot.
class Assignment {
 public:
  Assignment(const Inventory& inventory, const std::vector<NamedWindow>& given)
      : inventory_(inventory) {
    for (const NamedWindow& window : given) by_plot_.try_emplace(window.plot, &window);
  }

  void run(SearchScope scope, bool may_lack, PlotWindows& result);

 private:
  const NamedWindow* named(const std::optional<std::string>& plot) const {
    const auto found = by_plot_.find(plot);
    return found == by_plot_.end() ? nullptr : found->second;
  }

  const Inventory& inventory_;
  std::map<std::optional<std::string>, const NamedWindow*> by_plot_{};
};

void Assignment::run(SearchScope scope, bool may_lack, PlotWindows& result) {
  const std::vector<std::string>& names = inventory_.plot.levels();
  std::vector<std::string> missing;
  std::vector<std::size_t> in_stand;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const NamedWindow* own = named(names[i]);
    if (own == nullptr) own = named(kEveryPlot);
    if (own != nullptr) {
      result.domain_of_plot[i] = result.domains.size();
      result.domains.push_back({.name = names[i], .window = own->window});
    } else {
      in_stand.push_back(i);
    }
  }
  const NamedWindow* stand = named(std::nullopt);
  if (stand == nullptr) {
    for (const std::size_t plot : in_stand) missing.push_back(names[plot]);
  }
  if (may_lack && !missing.empty()) {
    result.plots_without_window = std::move(missing);
    return;
  }
  if (!missing.empty()) {
    throw InputError(fmt::format("no window for plot {}", data::list_of(missing)),
                     {.file = inventory_.file, .column = "plot"});
  }
  if (scope == SearchScope::kPlot) refuse_shared_window(in_stand.size());
  result.plots_in_window_of_stand = in_stand.size();
  if (in_stand.empty()) return;
  const std::string name = in_stand.size() == 1 && names.size() == 1 ? names[0] : "";
  for (const std::size_t plot : in_stand) result.domain_of_plot[plot] = result.domains.size();
  result.domains.push_back({.name = name, .window = stand->window});
}

/// Trees in a smaller unit than meters, which were converted, are inside of their windows by the
/// numbers of the file, too, if the windows have that unit: then these are too large.
void refuse_unconverted(const Inventory& inventory, const PlotWindows& windows) {
  const double unit_m = inventory.position_unit_m;
  if (unit_m >= 1.0 || inventory.trusts_units) return;
  std::size_t trees = 0;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    const Window* const window = windows.window_of(inventory, tree);
    if (window == nullptr || !has_position(inventory, tree)) continue;
    const Point in_file{inventory.x[tree] / unit_m, inventory.y[tree] / unit_m};
    if (!window->contains(in_file)) return;
    ++trees;
  }
  if (trees == 0) return;
  throw InputError(
      fmt::format(
          "x and y are converted to meters (times {:g}), but the trees lie in their windows "
          "by the numbers of the file, too, so that the windows may not be in meters; "
          "convert them, or use `trust_units`",
          unit_m),
      {.file = inventory.file, .column = "x"});
}

/// Plots all of whose trees are dead and neighbors only; those without a dbh may be alive.
std::vector<std::string> plots_of_dead(const Inventory& inventory) {
  std::vector<char> may_live(inventory.plot.levels().size(), 0);
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    const bool is_dead = inventory.is_neighbor_only(tree) && !std::isnan(inventory.dbh_cm[tree]);
    if (!is_dead) may_live[inventory.plot.code(tree)] = 1;
  }
  std::vector<std::string> plots;
  for (std::size_t code = 0; code < may_live.size(); ++code) {
    if (may_live[code] == 0) plots.push_back(inventory.plot.levels()[code]);
  }
  return plots;
}

}  // namespace

void refuse_shared_window(std::size_t plots) {
  if (plots <= 1) return;
  throw UsageError(
      fmt::format("neighbors are searched within each plot, but one window is given for {} plots; "
                  "use `per=stand`, or give each polygon the property 'plot' ('*' for every plot)",
                  plots));
}

const Window* PlotWindows::window_of(const Inventory& inventory, std::size_t tree) const {
  const std::optional<std::size_t> domain = domain_of_plot[inventory.plot.code(tree)];
  return domain ? &domains[*domain].window : nullptr;
}

PlotWindows plot_windows(const Inventory& inventory,
                         const std::vector<NamedWindow>& given,
                         SearchScope scope,
                         AssumedWindow assumed,
                         bool may_lack) {
  if (!inventory.has_coordinates()) {
    throw UsageError(
        "windows need the positions of trees, and the inventory has no x and y; give `plot_area`",
        {.file = inventory.file, .column = "`window`"});
  }
  PlotWindows result;
  result.domain_of_plot.resize(inventory.plot.levels().size());
  result.is_assumed = given.empty() && !may_lack;
  if (!result.is_assumed) {
    Assignment(inventory, given).run(scope, may_lack, result);
    refuse_unconverted(inventory, result);
  } else if (scope == SearchScope::kStand) {
    assume_stand(inventory, assumed, result);
  } else {
    assume_plots(inventory, assumed, result);
  }
  return result;
}

std::vector<char> trees_inside(const Inventory& inventory,
                               const PlotWindows& windows,
                               unsigned threads) {
  std::vector<char> inside(inventory.size(), 0);
  const std::size_t tasks = (inside.size() + kTreesPerWindowTask - 1) / kTreesPerWindowTask;
  parallel_for(tasks, threads, [&](std::size_t task) {
    const std::size_t end = std::min(inside.size(), (task + 1) * kTreesPerWindowTask);
    for (std::size_t tree = task * kTreesPerWindowTask; tree < end; ++tree) {
      const Window* window = windows.window_of(inventory, tree);
      if (window == nullptr || !has_position(inventory, tree)) continue;
      inside[tree] = window->contains({inventory.x[tree], inventory.y[tree]}) ? 1 : 0;
    }
  });
  return inside;
}

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
                     {.column = "`plot_area`"});
  }
  std::vector<SampledArea> areas = plots_of_unknown_area(inventory);
  for (const std::string& plot : plots_of_dead(inventory)) areas.push_back({.name = plot});
  for (const std::string& plot : inventory.plots_without_trees) areas.push_back({.name = plot});
  for (SampledArea& area : areas) area.area_m2 = plot_area_m2;
  return areas;
}

std::vector<std::string> take_unknown_plots(const Inventory& inventory,
                                            bool by_position,
                                            std::vector<SampledArea>& areas) {
  std::set<std::string_view> uncounted;
  for (std::size_t tree = 0; tree < inventory.size(); ++tree) {
    const bool is_unplaced = by_position && !has_position(inventory, tree);
    if (is_unplaced || std::isnan(inventory.dbh_cm[tree])) uncounted.insert(inventory.plot[tree]);
  }
  std::vector<std::string> unknown;
  std::erase_if(areas, [&](const SampledArea& area) {
    const bool is_unknown = area.trees.empty() && uncounted.contains(area.name);
    if (is_unknown) unknown.push_back(area.name);
    return is_unknown;
  });
  return unknown;
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

}  // namespace silvafit::stand
