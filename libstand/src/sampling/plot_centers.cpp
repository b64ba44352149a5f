// SPDX-License-Identifier: MIT
// Where the centers of plots are, and which trees are within reach of them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "sampling/sample_maker.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "units/density_indices.hpp"
#include "windows/coordinate_rounding.hpp"

namespace silvafit::stand {
namespace {

/// Distances are measured to centimeters at best.
constexpr double kDistanceTolerance = 0.01;

}  // namespace

bool is_placed(const Inventory& inventory, std::size_t tree) {
  return inventory.has_coordinates() && !std::isnan(inventory.x[tree]) &&
         !std::isnan(inventory.y[tree]);
}

Point SampleMaker::center_of(const PlotRecord* record, Origin origin) const {
  if (origin == Origin::kCenter) return {0.0, 0.0};
  return {record->x, record->y};
}

bool SampleMaker::is_within(std::size_t tree, Origin origin, double radius_m) const {
  const PlotRecord* const record = record_of(tree);
  if (origin == Origin::kMap && record == nullptr) return false;
  const Point center = center_of(record, origin);
  const double distance_m =
      std::hypot(inventory_.x[tree] - center.x, inventory_.y[tree] - center.y);
  const double rounding_m = coordinate_rounding_m(std::max(std::abs(center.x), std::abs(center.y)));
  return distance_m <= radius_m + kDistanceTolerance + rounding_m;
}

/// Whether trees of a plot are farther apart than its circle is wide, so that they cannot be those
/// that were counted in it.
bool SampleMaker::exceeds_circles() const {
  if (design_.subplots > 1 && !sample_.subplot_labels) return false;
  const data::TextColumn& labels =
      sample_.subplot_labels ? *sample_.subplot_labels : inventory_.plot;
  struct Extent {
    Point low{kInfinity, kInfinity};
    Point high{-kInfinity, -kInfinity};
    double reach_m = 0.0;
  };
  std::vector<Extent> extents(labels.levels().size());
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    if (!is_placed(inventory_, tree) || std::isnan(mapped_m(tree))) continue;
    auto& [low, high, reach] = extents[labels.code(tree)];
    low = {std::min(low.x, inventory_.x[tree]), std::min(low.y, inventory_.y[tree])};
    high = {std::max(high.x, inventory_.x[tree]), std::max(high.y, inventory_.y[tree])};
    reach = std::max(reach, mapped_m(tree));
  }
  return std::ranges::any_of(extents, [](const Extent& extent) {
    const double width_m = std::max(extent.high.x - extent.low.x, extent.high.y - extent.low.y);
    return width_m > 2.0 * (extent.reach_m + kDistanceTolerance);
  });
}

/// Positions are those of a map if at least as many trees are within reach of its centers as of the
/// origin; else they are from the center of the plot if that holds for half of the trees.
void SampleMaker::find_origin() {
  const bool has_subplots = design_.subplots > 1 || !design_.subplot.empty();
  if (inventory_.is_placed_by_subplots && has_subplots) {
    sample_.notes.emplace_back(
        "FIA's positions are from the center of the plot, so that they do not choose the trees of "
        "subplots, and all are taken as counted");
    return;
  }
  std::size_t placed = 0;
  std::size_t near_center = 0;
  std::size_t near_map = 0;
  const bool has_map = design_.plots && design_.plots->has_center && design_.subplots == 1 &&
                       design_.subplot.empty();
  for (std::size_t tree = 0; tree < inventory_.size(); ++tree) {
    if (!is_placed(inventory_, tree) || std::isnan(reach_m(tree))) continue;
    ++placed;
    if (is_within(tree, Origin::kCenter, mapped_m(tree))) ++near_center;
    if (has_map && is_within(tree, Origin::kMap, mapped_m(tree))) ++near_map;
  }
  if (placed == 0) return;
  if (near_map > 0 && near_map >= near_center) {
    origin_ = Origin::kMap;
    sample_.notes.emplace_back("centers of plots are x and y of the table of plots");
    return;
  }
  if (2 * near_center >= placed) {
    origin_ = Origin::kCenter;
    sample_.notes.emplace_back("positions of trees are relative to the center of the plot");
    return;
  }
  const std::string found =
      fmt::format("only {} of {} trees with positions are within their plots around the {}",
                  std::max(near_center, near_map),
                  placed,
                  has_map ? "origin or the centers of `plots`" : "origin");
  constexpr std::string_view kRemedy =
      "give the centers of plots as x and y in `plots`, in the coordinates of the trees";
  if (has_map || exceeds_circles()) {
    throw InputError(fmt::format("{}{}; {}",
                                 found,
                                 has_map ? "" : ", and they are farther apart than these are wide",
                                 kRemedy),
                     {.file = inventory_.file, .column = "x"});
  }
  sample_.notes.push_back(
      fmt::format("{}, so positions do not choose the trees, and all are taken as counted; {}",
                  found,
                  kRemedy));
}

}  // namespace silvafit::stand
