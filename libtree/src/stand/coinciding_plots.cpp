// SPDX-License-Identifier: MIT
#include "silvafit/tree/coinciding_plots.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <vector>

namespace silvafit::tree {
namespace {

/// The rectangle around the stems of a plot.
struct PlotBox {
  std::string plot{};
  std::size_t first_tree = 0;
  std::size_t trees = 0;
  double west = std::numeric_limits<double>::infinity();
  double east = -std::numeric_limits<double>::infinity();
  double south = std::numeric_limits<double>::infinity();
  double north = -std::numeric_limits<double>::infinity();

  void add(const Position& stem) {
    ++trees;
    west = std::min(west, stem.x_m);
    east = std::max(east, stem.x_m);
    south = std::min(south, stem.y_m);
    north = std::max(north, stem.y_m);
  }
  double area() const { return (east - west) * (north - south); }
};

double shared_area(const PlotBox& a, const PlotBox& b) {
  const double width = std::min(a.east, b.east) - std::max(a.west, b.west);
  const double length = std::min(a.north, b.north) - std::max(a.south, b.south);
  return std::max(0.0, width) * std::max(0.0, length);
}

bool coincide(const PlotBox& a, const PlotBox& b) {
  constexpr double kShare = 0.5;
  return shared_area(a, b) > kShare * std::min(a.area(), b.area());
}

/// From west to east.
std::vector<PlotBox> boxes_of(std::span<const Morphology> trees) {
  std::map<std::string, PlotBox> by_plot;
  for (std::size_t i = 0; i < trees.size(); ++i) {
    const auto [found, is_new] = by_plot.try_emplace(trees[i].plot);
    if (is_new) found->second.first_tree = i;
    found->second.add(trees[i].position);
  }
  std::vector<PlotBox> boxes;
  for (auto& [plot, box] : by_plot) {
    box.plot = plot;
    constexpr std::size_t kFewest = 3;
    if (box.trees >= kFewest && box.area() > 0.0) boxes.push_back(box);
  }
  std::ranges::stable_sort(boxes, {}, &PlotBox::west);
  return boxes;
}

}  // namespace

std::optional<std::pair<std::string, std::string>> coinciding_plots(
    std::span<const Morphology> trees) {
  const std::vector<PlotBox> boxes = boxes_of(trees);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t k = i + 1; k < boxes.size() && boxes[k].west < boxes[i].east; ++k) {
      if (!coincide(boxes[i], boxes[k])) continue;
      const bool in_order = boxes[i].first_tree < boxes[k].first_tree;
      return std::pair(boxes[in_order ? i : k].plot, boxes[in_order ? k : i].plot);
    }
  }
  return std::nullopt;
}

}  // namespace silvafit::tree
