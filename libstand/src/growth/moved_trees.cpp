// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <ranges>

#include "growth/growth_parts.hpp"
#include "silvafit/base/text.hpp"
#include "units/neighbor_search.hpp"

namespace silvafit::stand {
namespace {

struct Moved {
  std::size_t trees = 0;
  double farthest_m = 0.0;
  std::size_t row = 0;  ///< of the farthest, at the end
};

void find_moved(const Survivors& survivors, const std::vector<Point>& positions, Moved& moved) {
  const auto is_placed = [&positions](std::size_t row) {
    return std::isfinite(positions[row].x) && std::isfinite(positions[row].y);
  };
  std::map<std::uint32_t, std::size_t> end_of;
  for (const auto& [start, end] : survivors) {
    if (is_placed(start) && is_placed(end)) end_of.emplace(static_cast<std::uint32_t>(start), end);
  }
  const auto starts = std::views::keys(end_of);
  const NeighborSearch search({starts.begin(), starts.end()}, positions, std::less<>());
  NeighborSearch::Scratch scratch;
  std::vector<Neighbor> nearest;
  for (std::size_t i = 0; i < search.trees().size(); ++i) {
    const Point& from = positions[search.trees()[i]];
    const std::size_t end = end_of.at(search.trees()[i]);
    const double distance_m = std::hypot(positions[end].x - from.x, positions[end].y - from.y);
    search.nearest(i, 1, nearest, scratch);
    // Stems at one position are one tree.
    const bool is_far = !nearest.empty() && nearest.front().distance_m > kSameDistanceMeters &&
                        distance_m > nearest.front().distance_m;
    if (!is_far) continue;
    ++moved.trees;
    if (distance_m <= moved.farthest_m) continue;
    moved.farthest_m = distance_m;
    moved.row = end;
  }
}

}  // namespace

std::string describe_moved_trees(const Inventory& living, const std::vector<Survivors>& periods) {
  if (!living.has_coordinates()) return {};
  std::vector<Point> positions;
  for (std::size_t row = 0; row < living.size(); ++row) {
    positions.push_back({living.x[row], living.y[row]});
  }
  Moved moved;
  for (const Survivors& survivors : periods) find_moved(survivors, positions, moved);
  if (moved.trees == 0) return {};
  return fmt::format(
      "{} farther from the earlier position than the nearest neighbor did, at most "
      "{:.3g} m: plot {}, tree {}; if a number was given to another tree, give it a "
      "new one",
      counted(moved.trees, "tree stands", "trees stand"),
      moved.farthest_m,
      living.plot[moved.row],
      living.tree[moved.row]);
}

}  // namespace silvafit::stand
