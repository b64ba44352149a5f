// SPDX-License-Identifier: MIT
#include "windows/overlapping_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <cmath>
#include <utility>
#include <vector>

namespace silvafit::stand {
namespace {

namespace bg = boost::geometry;
using Box = bg::model::box<bg::model::d2::point_xy<double>>;
using BoxAndPlot = std::pair<Box, std::size_t>;
using BoxTree = bg::index::rtree<BoxAndPlot, bg::index::quadratic<16>>;

/// Adjacent plots share a border. If it was digitized twice or rounded to a centimeter, the plots
/// overlap in thin slivers.
constexpr double kShareOfSliver = 1e-3;

/// The positions of the trees of each plot.
std::vector<std::vector<Point>> points_by_plot(const Inventory& inventory) {
  std::vector<std::vector<Point>> points(inventory.plot.levels().size());
  for (std::size_t i = 0; i < inventory.size(); ++i) {
    if (std::isnan(inventory.x[i]) || std::isnan(inventory.y[i])) continue;
    points[inventory.plot.code(i)].push_back({inventory.x[i], inventory.y[i]});
  }
  return points;
}

/// The area of each plot, if it has one.
std::vector<std::optional<Window>> areas_of_plots(const Inventory& inventory,
                                                  const PlotWindows& windows) {
  std::vector<std::size_t> plots_of_domain(windows.domains.size(), 0);
  for (const auto& domain : windows.domain_of_plot) {
    if (domain) ++plots_of_domain[*domain];
  }
  const std::vector<std::vector<Point>> points = points_by_plot(inventory);
  std::vector<std::optional<Window>> areas;
  for (std::size_t plot = 0; plot < points.size(); ++plot) {
    const std::optional<std::size_t> domain = windows.domain_of_plot[plot];
    const bool is_own = domain && plots_of_domain[*domain] == 1;
    areas.push_back(is_own ? std::optional(windows.domains[*domain].window)
                           : Window::convex_hull(points[plot]));
  }
  return areas;
}

Box box_of(const Window& window) {
  return {{window.low().x, window.low().y}, {window.high().x, window.high().y}};
}

bool overlap(const Window& left, const Window& right) {
  const double smaller_m2 = std::min(left.area_m2(), right.area_m2());
  return left.is_same(right) || left.shared_area_m2(right) > kShareOfSliver * smaller_m2;
}

}  // namespace

std::string note_on_overlapping_plots(const Inventory& inventory, const PlotWindows& windows) {
  const std::vector<std::string>& names = inventory.plot.levels();
  if (names.size() < 2) return {};
  const std::vector<std::optional<Window>> areas = areas_of_plots(inventory, windows);
  std::vector<BoxAndPlot> boxes;
  for (std::size_t plot = 0; plot < areas.size(); ++plot) {
    if (areas[plot]) boxes.emplace_back(box_of(*areas[plot]), plot);
  }
  const BoxTree tree(boxes);
  std::size_t overlapping = 0;
  std::string first;
  for (const auto& [box, plot] : boxes) {
    // One pair is enough: if all plots cover each other, testing all pairs would take too long.
    std::size_t other = plot;
    for (auto near = tree.qbegin(bg::index::intersects(box)); near != tree.qend(); ++near) {
      if (near->second == plot || !overlap(*areas[plot], *areas[near->second])) continue;
      other = near->second;
      break;
    }
    if (other == plot) continue;
    if (overlapping++ == 0) first = fmt::format("{} and {}", names[plot], names[other]);
  }
  if (overlapping == 0) return {};
  return fmt::format(
      "{} plots overlap, for example {}, and neighbors are searched across plots; if positions are "
      "measured from each plot's own corner or center, use `per=plot`",
      overlapping,
      first);
}

}  // namespace silvafit::stand
