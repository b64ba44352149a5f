// SPDX-License-Identifier: MIT
#include "units/edge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "silvafit/base/parallel.hpp"
#include "silvafit/base/text.hpp"
#include "windows/eroded_areas.hpp"

namespace silvafit::stand {
namespace {

constexpr std::size_t kTreesPerEdgeTask = 4096;
Point position_of(const Inventory& inventory, std::size_t tree) {
  return {inventory.x[tree], inventory.y[tree]};
}

/// Calls a function for every tree, on several threads.
template <class Function>
void for_each_tree(std::size_t trees, unsigned threads, Function function) {
  parallel_for((trees + kTreesPerEdgeTask - 1) / kTreesPerEdgeTask, threads, [&](std::size_t task) {
    const std::size_t end = std::min(trees, (task + 1) * kTreesPerEdgeTask);
    for (std::size_t tree = task * kTreesPerEdgeTask; tree < end; ++tree) function(tree);
  });
}

class EdgeWorker {
 public:
  EdgeWorker(const Inventory& inventory,
             const PlotWindows& windows,
             const std::vector<char>& inside,
             const StructuralUnitOptions& options,
             StructuralUnits& units)
      : inventory_(inventory),
        windows_(windows),
        inside_(inside),
        options_(options),
        units_(units) {}

  void keep_inside() { units_.core = inside_; }
  void keep_beyond_buffer();
  void keep_certain_neighbors();
  void report_outside();
  void report_plots_outside();

 private:
  const Window& window_of(std::size_t tree) const { return *windows_.window_of(inventory_, tree); }
  double to_boundary_m(std::size_t tree) const {
    return window_of(tree).distance_to_boundary_m(position_of(inventory_, tree));
  }
  double farthest_m(std::size_t tree) const {
    return units_.distance_m[(tree + 1) * units_.neighbors - 1];
  }
  void weight_domain(std::size_t domain, const std::vector<std::size_t>& trees);

  const Inventory& inventory_;
  const PlotWindows& windows_;
  const std::vector<char>& inside_;
  const StructuralUnitOptions& options_;
  StructuralUnits& units_;
};

void EdgeWorker::keep_beyond_buffer() {
  units_.core.assign(inside_.size(), 0);
  for_each_tree(inside_.size(), options_.threads, [this](std::size_t tree) {
    if (inside_[tree] == 0) return;
    // Trees at exactly the buffer's width are core trees; the tolerance covers rounding.
    const double nearest_m = options_.buffer_m - window_of(tree).rounding_m();
    units_.core[tree] = to_boundary_m(tree) >= nearest_m ? 1 : 0;
  });
}

/// Hanisch 1984: a tree outside would be farther than the n-th neighbor, so the unit is certainly
/// complete.
void EdgeWorker::keep_certain_neighbors() {
  units_.core.assign(inside_.size(), 0);
  for_each_tree(inside_.size(), options_.threads, [this](std::size_t tree) {
    // NaN (too few neighbors) is not smaller.
    if (inside_[tree] == 0) return;
    const double room_m = to_boundary_m(tree) - window_of(tree).rounding_m();
    units_.core[tree] = farthest_m(tree) < room_m ? 1 : 0;
  });
  units_.weight.assign(inside_.size(), 0.0);
  std::vector<std::vector<std::size_t>> kept(windows_.domains.size());
  for (std::size_t tree = 0; tree < inside_.size(); ++tree) {
    if (units_.core[tree] == 0) continue;
    kept[*windows_.domain_of_plot[inventory_.plot.code(tree)]].push_back(tree);
  }
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (!kept[i].empty()) weight_domain(i, kept[i]);
  }
}

/// Weights are the window's area divided by the area in which such a tree would be a core tree.
void EdgeWorker::weight_domain(std::size_t domain, const std::vector<std::size_t>& trees) {
  const Window& window = windows_.domains[domain].window;
  std::vector<double> margins_m;
  margins_m.reserve(trees.size());
  for (const std::size_t tree : trees) margins_m.push_back(farthest_m(tree));
  const std::vector<double> areas_m2 = eroded_areas_m2(window, margins_m);
  for (std::size_t i = 0; i < trees.size(); ++i) {
    if (areas_m2[i] > 0.0) {
      units_.weight[trees[i]] = window.area_m2() / areas_m2[i];
    } else {
      // The eroded area is lost in rounding, so no weight can be computed.
      units_.core[trees[i]] = 0;
    }
  }
}

void EdgeWorker::report_outside() {
  UnitFindings& findings = units_.findings;
  for (std::size_t tree = 0; tree < inside_.size(); ++tree) {
    const Point point = position_of(inventory_, tree);
    if (std::isnan(point.x) || std::isnan(point.y)) continue;
    if (windows_.window_of(inventory_, tree) == nullptr) continue;
    ++findings.placed;
    if (inside_[tree] == 0) ++findings.outside;
    findings.low = {std::min(findings.low.x, point.x), std::min(findings.low.y, point.y)};
    findings.high = {std::max(findings.high.x, point.x), std::max(findings.high.y, point.y)};
  }
  if (findings.outside > 0) report_plots_outside();
}

/// If no tree of a plot is inside its window, the window is probably wrong.
void EdgeWorker::report_plots_outside() {
  std::vector<std::size_t> inside(windows_.domains.size(), 0);
  std::vector<std::size_t> outside(windows_.domains.size(), 0);
  for (std::size_t tree = 0; tree < inside_.size(); ++tree) {
    const std::optional<std::size_t> domain = windows_.domain_of_plot[inventory_.plot.code(tree)];
    const Point point = position_of(inventory_, tree);
    if (!domain || std::isnan(point.x) || std::isnan(point.y)) continue;
    ++(inside_[tree] == 0 ? outside : inside)[*domain];
  }
  for (std::size_t i = 0; i < windows_.domains.size(); ++i) {
    if (inside[i] > 0 || outside[i] == 0) continue;
    units_.findings.plots_outside.add({windows_.domains[i].name});
  }
}

}  // namespace

std::string outside_note(std::size_t trees, EdgeCorrection edge) {
  const bool is_torus = edge == EdgeCorrection::kTorus;
  return fmt::format("{} outside the window: {}",
                     counted(trees, "tree is", "trees are"),
                     is_torus ? "ignored with `edge=torus`" : "used only as neighbors");
}

void correct_edge(const Inventory& inventory,
                  const PlotWindows& windows,
                  const std::vector<char>& inside,
                  const StructuralUnitOptions& options,
                  StructuralUnits& units) {
  EdgeWorker worker(inventory, windows, inside, options, units);
  worker.report_outside();
  switch (options.edge) {
    case EdgeCorrection::kBuffer:
      worker.keep_beyond_buffer();
      break;
    case EdgeCorrection::kHanisch:
      worker.keep_certain_neighbors();
      break;
    case EdgeCorrection::kNone:
    case EdgeCorrection::kTorus:
      worker.keep_inside();
      break;
  }
}

}  // namespace silvafit::stand
