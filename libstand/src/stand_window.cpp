// SPDX-License-Identifier: MIT
#include "stand_window.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::stand {
namespace {

/// Trees at the buffer's width are core trees in spite of rounding.
constexpr double kRounding_m = 1e-9;
constexpr std::size_t kTreesPerTask = 4096;

bool has_position(Point point) { return !std::isnan(point.x) && !std::isnan(point.y); }

struct Bounds {
  Point low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Point high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

  void include(Point point) {
    low = {std::min(low.x, point.x), std::min(low.y, point.y)};
    high = {std::max(high.x, point.x), std::max(high.y, point.y)};
  }
  bool has_area() const { return low.x < high.x && low.y < high.y; }
  double area_m2() const { return has_area() ? (high.x - low.x) * (high.y - low.y) : 0.0; }
};

std::vector<Bounds> bounds_of_plots(const Inventory& inventory, std::span<const Point> positions) {
  std::vector<Bounds> bounds(inventory.plot.levels().size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (has_position(positions[i])) bounds[inventory.plot.code(i)].include(positions[i]);
  }
  return bounds;
}

Bounds bounds_of_stand(const std::vector<Bounds>& plots) {
  Bounds stand;
  for (const Bounds& plot : plots) {
    if (!(plot.low.x <= plot.high.x)) continue;
    stand.include(plot.low);
    stand.include(plot.high);
  }
  return stand;
}

/// A window for each plot, none where a plot has no area.
using PlotWindows = std::vector<std::optional<Window>>;

PlotWindows bounding_windows(const Inventory& inventory,
                             const std::vector<Bounds>& plots,
                             SearchScope scope,
                             std::vector<std::string>& notes) {
  PlotWindows windows(plots.size());
  if (scope == SearchScope::kStand) {
    const Bounds stand = bounds_of_stand(plots);
    if (stand.has_area()) {
      std::ranges::fill(windows, Window::rectangle(stand.low, stand.high));
    }
    notes.push_back(
        fmt::format("no window is given: the rectangle around all trees is taken, x {} "
                    "to {}, y {} to {}",
                    stand.low.x,
                    stand.high.x,
                    stand.low.y,
                    stand.high.y));
    return windows;
  }
  std::vector<std::string> without_area;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    if (plots[i].has_area()) {
      windows[i] = Window::rectangle(plots[i].low, plots[i].high);
    } else {
      without_area.push_back(inventory.plot.levels()[i]);
    }
  }
  notes.emplace_back(
      "no window is given: the rectangle around the trees of each plot is taken, which is smaller "
      "than the plot");
  if (!without_area.empty()) {
    notes.push_back(fmt::format("trees on one line make no window, so there is no core tree in: {}",
                                fmt::join(without_area, ", ")));
  }
  return windows;
}

PlotWindows given_windows(const Inventory& inventory, const StructuralUnitOptions& options) {
  const std::vector<std::string>& names = inventory.plot.levels();
  PlotWindows windows(names.size());
  std::vector<std::string> missing;
  std::vector<std::string> of_no_plot;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto find = [&options](const std::optional<std::string>& plot) {
      return std::ranges::find(options.windows, plot, &NamedWindow::plot);
    };
    auto found = find(names[i]);
    if (found == options.windows.end()) {
      found = find(std::nullopt);
      of_no_plot.push_back(names[i]);
    }
    if (found == options.windows.end()) {
      missing.push_back(names[i]);
    } else {
      windows[i] = found->window;
    }
  }
  if (!missing.empty()) {
    throw InputError(fmt::format("the windows have none for plot {}", fmt::join(missing, ", ")),
                     {.file = inventory.file, .column = "plot"});
  }
  if (options.scope == SearchScope::kPlot && of_no_plot.size() > 1) {
    throw UsageError(fmt::format(
        "neighbors are searched within each plot, but one window is given for {} plots; "
        "use --per stand, or give each polygon its property 'plot'",
        of_no_plot.size()));
  }
  return windows;
}

void note_local_positions(const std::vector<Bounds>& plots, std::vector<std::string>& notes) {
  double sum_m2 = 0.0;
  for (const Bounds& plot : plots) sum_m2 += plot.area_m2();
  if (plots.size() > 1 && sum_m2 > 1.5 * bounds_of_stand(plots).area_m2()) {
    notes.emplace_back(
        "the plots overlap; if positions are counted from each plot's own corner, use --per plot");
  }
}

void report_outside(const Inventory& inventory,
                    std::size_t outside,
                    std::size_t placed,
                    const Bounds& stand,
                    std::vector<std::string>& notes) {
  if (outside == 0) return;
  if (outside == placed) {
    throw InputError(
        fmt::format("all trees stand outside the window; they are between x {} and {}, "
                    "y {} and {} m: is the window in the same coordinates?",
                    stand.low.x,
                    stand.high.x,
                    stand.low.y,
                    stand.high.y),
        {.file = inventory.file});
  }
  notes.push_back(
      fmt::format("{} trees stand outside the window and serve as neighbors only", outside));
}

}  // namespace

std::vector<char> core_trees(const Inventory& inventory,
                             std::span<const Point> positions,
                             const StructuralUnitOptions& options,
                             std::vector<std::string>& notes) {
  const std::vector<Bounds> plots = bounds_of_plots(inventory, positions);
  if (options.scope == SearchScope::kStand) note_local_positions(plots, notes);
  std::vector<char> core(positions.size(), 0);
  const bool uses_buffer = options.edge == EdgeCorrection::kBuffer;
  if (options.windows.empty() && !uses_buffer) {
    std::ranges::transform(
        positions, core.begin(), [](Point point) { return has_position(point) ? 1 : 0; });
    return core;
  }
  const PlotWindows windows = options.windows.empty()
                                  ? bounding_windows(inventory, plots, options.scope, notes)
                                  : given_windows(inventory, options);
  std::vector<char> is_outside(positions.size(), 0);
  const auto classify = [&](std::size_t tree) {
    const Point point = positions[tree];
    const std::optional<Window>& window = windows[inventory.plot.code(tree)];
    if (!has_position(point) || !window) return;
    is_outside[tree] = window->contains(point) ? 0 : 1;
    if (is_outside[tree] != 0) return;
    core[tree] =
        !uses_buffer || window->distance_to_boundary_m(point) >= options.buffer_m - kRounding_m;
  };
  const std::size_t tasks = (positions.size() + kTreesPerTask - 1) / kTreesPerTask;
  parallel_for(tasks, options.threads, [&](std::size_t task) {
    const std::size_t end = std::min(positions.size(), (task + 1) * kTreesPerTask);
    for (std::size_t tree = task * kTreesPerTask; tree < end; ++tree) classify(tree);
  });
  report_outside(inventory,
                 static_cast<std::size_t>(std::ranges::count(is_outside, 1)),
                 static_cast<std::size_t>(std::ranges::count_if(positions, has_position)),
                 bounds_of_stand(plots),
                 notes);
  return core;
}

}  // namespace silvafit::stand
