// SPDX-License-Identifier: MIT
#include "silvafit/stand/structural_units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>

#include "neighbor_search.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/data/table.hpp"
#include "stand_window.hpp"

namespace silvafit::stand {
namespace {

constexpr std::size_t kMostNeighbors = 64;
constexpr std::size_t kTreesPerTask = 1024;
constexpr double kPi = std::numbers::pi;
// Equality is met in spite of rounding: at the limit angle a pair does not count (strictly
// smaller), at the touching distance crowns do not overlap (strictly larger).
constexpr double kSameAngle_rad = 1e-11;
constexpr double kSameLength_m = 1e-9;

void check(const Inventory& inventory, const StructuralUnitOptions& options) {
  if (options.neighbors < 1 || options.neighbors > kMostNeighbors) {
    throw UsageError(fmt::format("{} is not between 1 and {}", options.neighbors, kMostNeighbors),
                     {.column = "--neighbors"});
  }
  if (options.alpha0_deg && !(*options.alpha0_deg > 0.0 && *options.alpha0_deg <= 180.0)) {
    throw UsageError(fmt::format("{} degrees is not above 0 and up to 180", *options.alpha0_deg),
                     {.column = "--alpha"});
  }
  if (!(options.buffer_m >= 0.0) || std::isinf(options.buffer_m)) {
    throw UsageError(fmt::format("{} m is not 0 or more", options.buffer_m),
                     {.column = "--buffer"});
  }
  if (!inventory.has_coordinates()) {
    throw UsageError("structural units need the columns x and y", {.file = inventory.file});
  }
}

/// A label as an integer, if it is one.
bool is_integer(std::string_view label, long long& value) {
  const auto [end, status] = std::from_chars(label.data(), label.data() + label.size(), value);
  return status == std::errc() && end == label.data() + label.size();
}

/// Integers by value and before other labels, those by their characters. Negative, zero or
/// positive.
int compare_labels(std::string_view left, std::string_view right) {
  long long left_value = 0;
  long long right_value = 0;
  const bool left_is_integer = is_integer(left, left_value);
  const bool right_is_integer = is_integer(right, right_value);
  if (left_is_integer != right_is_integer) return left_is_integer ? -1 : 1;
  if (left_is_integer && left_value != right_value) return left_value < right_value ? -1 : 1;
  return left.compare(right);
}

/// The indices of one tree from its neighbors.
class Unit {
 public:
  Unit(const Inventory& inventory, std::span<const Point> positions, std::size_t tree)
      : inventory_(inventory), positions_(positions), tree_(tree) {}

  double uniform_angle(std::span<const Neighbor> neighbors, double alpha0_rad) const;
  double mingling(std::span<const Neighbor> neighbors) const;
  double dominance(std::span<const Neighbor> neighbors) const;
  double crowding(std::span<const Neighbor> neighbors) const;

 private:
  const Inventory& inventory_;
  std::span<const Point> positions_;
  std::size_t tree_;
};

double share(std::size_t count, std::size_t total) {
  return static_cast<double>(count) / static_cast<double>(total);
}

double Unit::uniform_angle(std::span<const Neighbor> neighbors, double alpha0_rad) const {
  const std::size_t n = neighbors.size();
  if (n < 2) return data::kMissing;
  std::array<double, kMostNeighbors> azimuths{};
  for (std::size_t i = 0; i < n; ++i) {
    const Point& other = positions_[neighbors[i].tree];
    const double east = other.x - positions_[tree_].x;
    const double north = other.y - positions_[tree_].y;
    // A stem at the same place has no direction.
    if (east == 0.0 && north == 0.0) return data::kMissing;
    azimuths[i] = std::atan2(east, north);
  }
  std::sort(azimuths.begin(), azimuths.begin() + static_cast<std::ptrdiff_t>(n));
  std::size_t small = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double gap =
        i + 1 < n ? azimuths[i + 1] - azimuths[i] : azimuths[0] + 2.0 * kPi - azimuths[n - 1];
    if (std::min(gap, 2.0 * kPi - gap) < alpha0_rad - kSameAngle_rad) ++small;
  }
  return share(small, n);
}

double Unit::mingling(std::span<const Neighbor> neighbors) const {
  if (inventory_.species.is_missing(tree_)) return data::kMissing;
  std::size_t other = 0;
  for (const Neighbor& neighbor : neighbors) {
    if (inventory_.species.is_missing(neighbor.tree)) return data::kMissing;
    if (inventory_.species.code(neighbor.tree) != inventory_.species.code(tree_)) ++other;
  }
  return share(other, neighbors.size());
}

double Unit::dominance(std::span<const Neighbor> neighbors) const {
  const auto is_not_smaller = [this](const Neighbor& neighbor) {
    return inventory_.dbh_cm[neighbor.tree] >= inventory_.dbh_cm[tree_];
  };
  const auto count = std::ranges::count_if(neighbors, is_not_smaller);
  return share(static_cast<std::size_t>(count), neighbors.size());
}

double Unit::crowding(std::span<const Neighbor> neighbors) const {
  std::size_t overlapping = 0;
  for (const Neighbor& neighbor : neighbors) {
    const double reach_m = (inventory_.cw_m[tree_] + inventory_.cw_m[neighbor.tree]) / 2.0;
    if (std::isnan(reach_m)) return data::kMissing;
    if (reach_m > neighbor.distance_m + kSameLength_m) ++overlapping;
  }
  return share(overlapping, neighbors.size());
}

/// Fills the units of all trees.
class Calculator {
 public:
  Calculator(const Inventory& inventory, const StructuralUnitOptions& options);
  StructuralUnits run();

 private:
  void build_searches();
  void compute_trees(const NeighborSearch& search, std::size_t begin, std::size_t end);
  void compute_tree(std::size_t tree, std::span<const Neighbor> neighbors);
  void add_notes();

  const Inventory& inventory_;
  const StructuralUnitOptions& options_;
  std::vector<Point> positions_{};
  std::vector<NeighborSearch> searches_{};
  StructuralUnits units_{};
};

Calculator::Calculator(const Inventory& inventory, const StructuralUnitOptions& options)
    : inventory_(inventory), options_(options) {
  const std::size_t trees = inventory.size();
  for (std::size_t i = 0; i < trees; ++i) positions_.push_back({inventory.x[i], inventory.y[i]});
  units_.neighbors = options.neighbors;
  units_.scope = options.scope;
  units_.alpha0_deg =
      options.alpha0_deg.value_or(360.0 / static_cast<double>(options.neighbors + 1));
  units_.W.assign(trees, data::kMissing);
  units_.M.assign(trees, data::kMissing);
  units_.U.assign(trees, data::kMissing);
  if (!inventory.cw_m.empty()) units_.C.assign(trees, data::kMissing);
  units_.nearest.assign(trees * options.neighbors, kNoTree);
  units_.distance_m.assign(trees * options.neighbors, data::kMissing);
}

void Calculator::build_searches() {
  const bool by_plot = options_.scope == SearchScope::kPlot;
  std::vector<std::vector<std::uint32_t>> groups(by_plot ? inventory_.plot.levels().size() : 1);
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    if (std::isnan(positions_[i].x) || std::isnan(positions_[i].y)) continue;
    groups[by_plot ? inventory_.plot.code(i) : 0].push_back(static_cast<std::uint32_t>(i));
  }
  std::erase_if(groups, [](const auto& group) { return group.empty(); });
  std::vector<std::optional<NeighborSearch>> built(groups.size());
  parallel_for(groups.size(), options_.threads, [&](std::size_t i) {
    built[i].emplace(std::move(groups[i]), positions_);
  });
  for (auto& search : built) searches_.push_back(std::move(*search));
}

void Calculator::compute_tree(std::size_t tree, std::span<const Neighbor> neighbors) {
  const std::size_t first = tree * options_.neighbors;
  for (std::size_t i = 0; i < neighbors.size(); ++i) {
    units_.nearest[first + i] = neighbors[i].tree;
    units_.distance_m[first + i] = neighbors[i].distance_m;
  }
  if (neighbors.size() < options_.neighbors) return;
  const Unit unit(inventory_, positions_, tree);
  units_.W[tree] = unit.uniform_angle(neighbors, units_.alpha0_deg * kPi / 180.0);
  units_.M[tree] = unit.mingling(neighbors);
  units_.U[tree] = unit.dominance(neighbors);
  if (!units_.C.empty()) units_.C[tree] = unit.crowding(neighbors);
}

void Calculator::compute_trees(const NeighborSearch& search, std::size_t begin, std::size_t end) {
  const auto smaller_id = [this](std::uint32_t left, std::uint32_t right) {
    const int by_tree = compare_labels(inventory_.tree[left], inventory_.tree[right]);
    if (by_tree != 0) return by_tree < 0;
    const int by_plot = compare_labels(inventory_.plot[left], inventory_.plot[right]);
    return by_plot != 0 ? by_plot < 0 : left < right;
  };
  const NeighborSearch::Before before = smaller_id;
  std::vector<Neighbor> neighbors;
  for (std::size_t i = begin; i < end; ++i) {
    search.nearest(i, options_.neighbors, before, neighbors);
    compute_tree(search.trees()[i], neighbors);
  }
}

void Calculator::add_notes() {
  std::size_t alone = 0;
  std::size_t coincident = 0;
  std::size_t without_crown = 0;
  std::size_t without_position = 0;
  for (std::size_t tree = 0; tree < positions_.size(); ++tree) {
    const std::size_t first = tree * options_.neighbors;
    if (std::isnan(positions_[tree].x) || std::isnan(positions_[tree].y)) {
      ++without_position;
    } else if (units_.nearest[first + options_.neighbors - 1] == kNoTree) {
      ++alone;
    } else {
      if (units_.distance_m[first] == 0.0) ++coincident;
      if (!units_.C.empty() && std::isnan(units_.C[tree])) ++without_crown;
    }
  }
  const auto note = [this](std::size_t count, std::string_view what) {
    if (count > 0) units_.notes.push_back(fmt::format("{} trees {}", count, what));
  };
  note(without_position, "have no position and no structural unit");
  note(alone, fmt::format("have fewer than {} neighbors and no indices", options_.neighbors));
  note(coincident, "have a neighbor at the same place, which has no direction: W is missing");
  note(without_crown, "or a neighbor of theirs have no crown width: C is missing");
  if (units_.C.empty()) units_.notes.emplace_back("there are no crown widths: C is missing");
}

StructuralUnits Calculator::run() {
  units_.core = core_trees(inventory_, positions_, options_, units_.notes);
  build_searches();
  struct Task {
    const NeighborSearch* search;
    std::size_t begin;
    std::size_t end;
  };
  std::vector<Task> tasks;
  for (const NeighborSearch& search : searches_) {
    const std::size_t trees = search.trees().size();
    for (std::size_t begin = 0; begin < trees; begin += kTreesPerTask) {
      tasks.push_back({&search, begin, std::min(trees, begin + kTreesPerTask)});
    }
  }
  parallel_for(tasks.size(), options_.threads, [&](std::size_t i) {
    compute_trees(*tasks[i].search, tasks[i].begin, tasks[i].end);
  });
  add_notes();
  return std::move(units_);
}

}  // namespace

StructuralUnits structural_units(const Inventory& inventory, const StructuralUnitOptions& options) {
  check(inventory, options);
  return Calculator(inventory, options).run();
}

}  // namespace silvafit::stand
