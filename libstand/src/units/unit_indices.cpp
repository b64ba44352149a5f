// SPDX-License-Identifier: MIT
#include "units/unit_indices.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "silvafit/data/table.hpp"
#include "windows/coordinate_rounding.hpp"

namespace silvafit::stand {
namespace {

// Tolerance for equality: at the limit angle a pair does not count (strictly smaller), at the
// touching distance crowns do not overlap (strictly larger). This is the minimum error of the
// arithmetic; for large coordinates their own rounding is larger.
constexpr double kSameAngleRadians = 1e-11;
constexpr double kSameLengthMeters = 1e-9;

/// The largest effect of rounding on a neighbor's position relative to a tree.
double rounding_m(const Inventory& inventory, std::size_t tree, double distance_m) {
  const double own_m = std::max(std::abs(inventory.x[tree]), std::abs(inventory.y[tree]));
  return coordinate_rounding_m(own_m + distance_m);
}

double share(std::size_t count, std::size_t total) {
  return static_cast<double>(count) / static_cast<double>(total);
}

/// Radius of a crown in a direction (a unit vector), on the quarter ellipse between the two
/// measured radii that enclose it.
double radius_towards(const Inventory& inventory, std::size_t tree, double east, double north) {
  const double along_x = east >= 0.0 ? inventory.cr_e_m[tree] : inventory.cr_w_m[tree];
  const double along_y = north >= 0.0 ? inventory.cr_n_m[tree] : inventory.cr_s_m[tree];
  if (east == 0.0) return along_y;
  if (north == 0.0) return along_x;
  if (std::isnan(along_x) || std::isnan(along_y)) return data::kMissing;
  // The ellipse degenerates to a line along an axis, or to a point.
  if (along_x == 0.0 || along_y == 0.0) return 0.0;
  return along_x * along_y / std::hypot(along_y * east, along_x * north);
}

}  // namespace

const std::vector<double>& sizes_of(const Inventory& inventory, SizeMeasure measure) {
  switch (measure) {
    case SizeMeasure::kHeight:
      return inventory.h_m;
    case SizeMeasure::kCrownWidth:
      return inventory.cw_m;
    case SizeMeasure::kDbh:
      break;
  }
  return inventory.dbh_cm;
}

double shared_area_m2(double radius_m, double other_radius_m, double distance_m) {
  const double large = std::max(radius_m, other_radius_m);
  const double small = std::min(radius_m, other_radius_m);
  if (distance_m >= large + small) return 0.0;
  if (distance_m <= large - small) return std::numbers::pi * small * small;
  // The chord through the two intersections cuts a segment off each circle.
  const double to_chord =
      (distance_m * distance_m + large * large - small * small) / (2.0 * distance_m);
  const auto segment = [](double radius, double height) {
    const double cosine = std::clamp(height / radius, -1.0, 1.0);
    return radius * radius * (std::acos(cosine) - cosine * std::sqrt(1.0 - cosine * cosine));
  };
  return segment(large, to_chord) + segment(small, distance_m - to_chord);
}

bool is_at_same_place(const Inventory& inventory, std::size_t tree, double distance_m) {
  return distance_m <= rounding_m(inventory, tree, distance_m);
}

double UnitIndices::uniform_angle(std::span<const Neighbor> neighbors, double alpha0_rad) const {
  const std::size_t n = neighbors.size();
  if (n < 2) return data::kMissing;
  struct Direction {
    double azimuth_rad = 0.0;
    double rounding_rad = 0.0;
  };
  std::array<Direction, kMostNeighbors> directions{};
  for (std::size_t i = 0; i < n; ++i) {
    const Neighbor& neighbor = neighbors[i];
    // A stem at the same place has no direction.
    if (is_at_same_place(inventory_, tree_, neighbor.distance_m)) return data::kMissing;
    const double off_m = rounding_m(inventory_, tree_, neighbor.distance_m);
    directions[i] = {std::atan2(neighbor.east_m, neighbor.north_m), off_m / neighbor.distance_m};
  }
  const std::span<Direction> known(directions.data(), n);
  std::ranges::sort(known, {}, &Direction::azimuth_rad);
  std::size_t small = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Direction& next = known[(i + 1) % n];
    const double turn = i + 1 < n ? 0.0 : 2.0 * std::numbers::pi;
    const double gap = next.azimuth_rad + turn - known[i].azimuth_rad;
    const double same = std::max(kSameAngleRadians, next.rounding_rad + known[i].rounding_rad);
    if (std::min(gap, 2.0 * std::numbers::pi - gap) < alpha0_rad - same) ++small;
  }
  return share(small, n);
}

double UnitIndices::mingling(std::span<const Neighbor> neighbors) const {
  if (inventory_.species.is_missing(tree_)) return data::kMissing;
  std::size_t other = 0;
  for (const Neighbor& neighbor : neighbors) {
    if (inventory_.species.is_missing(neighbor.tree)) return data::kMissing;
    if (inventory_.species.code(neighbor.tree) != inventory_.species.code(tree_)) ++other;
  }
  return share(other, neighbors.size());
}

double UnitIndices::dominance(std::span<const Neighbor> neighbors) const {
  const std::vector<double>& sizes = sizes_of(inventory_, options_.size);
  std::size_t not_smaller = 0;
  for (const Neighbor& neighbor : neighbors) {
    if (std::isnan(sizes[neighbor.tree]) || std::isnan(sizes[tree_])) return data::kMissing;
    if (sizes[neighbor.tree] >= sizes[tree_]) ++not_smaller;
  }
  return share(not_smaller, neighbors.size());
}

/// Sum of the facing radii of the two crowns.
double UnitIndices::reach_m(const Neighbor& neighbor) const {
  // Without a direction there is no facing radius.
  const bool has_direction = !is_at_same_place(inventory_, tree_, neighbor.distance_m);
  if (options_.reach == CrownReach::kMeanWidth || !has_direction) {
    return (inventory_.cw_m[tree_] + inventory_.cw_m[neighbor.tree]) / 2.0;
  }
  const double length = std::hypot(neighbor.east_m, neighbor.north_m);
  // Due north uses neither the east nor the west radius, which may differ or be unknown.
  const double off_m = rounding_m(inventory_, tree_, neighbor.distance_m);
  const double east = std::abs(neighbor.east_m) <= off_m ? 0.0 : neighbor.east_m / length;
  const double north = std::abs(neighbor.north_m) <= off_m ? 0.0 : neighbor.north_m / length;
  return radius_towards(inventory_, tree_, east, north) +
         radius_towards(inventory_, neighbor.tree, -east, -north);
}

double UnitIndices::crowding(std::span<const Neighbor> neighbors) const {
  std::size_t overlapping = 0;
  for (const Neighbor& neighbor : neighbors) {
    const double reach = reach_m(neighbor);
    if (std::isnan(reach)) return data::kMissing;
    const double same_m =
        std::max(kSameLengthMeters, rounding_m(inventory_, tree_, neighbor.distance_m));
    if (reach > neighbor.distance_m + same_m) ++overlapping;
  }
  return share(overlapping, neighbors.size());
}

double UnitIndices::crown_overlap(std::span<const Neighbor> neighbors) const {
  const double radius = inventory_.cw_m[tree_] / 2.0;
  double sum = 0.0;
  for (const Neighbor& neighbor : neighbors) {
    // A missing width makes the sum missing.
    const double other = inventory_.cw_m[neighbor.tree] / 2.0;
    if (std::isnan(radius) || std::isnan(other)) return data::kMissing;
    sum +=
        shared_area_m2(radius, other, neighbor.distance_m) / (std::numbers::pi * radius * radius);
  }
  return sum / static_cast<double>(neighbors.size());
}

double UnitIndices::differentiation(std::span<const Neighbor> neighbors) const {
  const std::vector<double>& sizes = sizes_of(inventory_, options_.size);
  const double own = sizes[tree_];
  double sum = 0.0;
  for (const Neighbor& neighbor : neighbors) {
    const double other = sizes[neighbor.tree];
    if (std::isnan(other) || std::isnan(own)) return data::kMissing;
    sum += 1.0 - std::min(own, other) / std::max(own, other);
  }
  return sum / static_cast<double>(neighbors.size());
}

double UnitIndices::hegyi(std::span<const Neighbor> neighbors) const {
  double sum = 0.0;
  for (const Neighbor& neighbor : neighbors) {
    // Competition at distance 0 would be infinite.
    if (is_at_same_place(inventory_, tree_, neighbor.distance_m)) return data::kMissing;
    sum += inventory_.dbh_cm[neighbor.tree] / inventory_.dbh_cm[tree_] / neighbor.distance_m;
  }
  return sum;
}

}  // namespace silvafit::stand
