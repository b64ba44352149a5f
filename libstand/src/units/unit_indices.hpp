// SPDX-License-Identifier: MIT
// The indices of one tree from its neighbors.
#pragma once

#include <cstddef>
#include <span>

#include "silvafit/stand/structural_units.hpp"
#include "units/neighbor_search.hpp"

namespace silvafit::stand {

inline constexpr std::size_t kMostNeighbors = 64;

/// Whether a neighbor differs from a tree only by rounding, so that it has no direction.
bool is_at_same_place(const Inventory& inventory, std::size_t tree, double distance_m);

/// A reference tree. Every index is NaN if unknown, and uses all given neighbors. Rounding of the
/// coordinates, which grows with them, does not affect any index.
class UnitIndices {
 public:
  UnitIndices(const Inventory& inventory, const StructuralUnitOptions& options, std::size_t tree)
      : inventory_(inventory), options_(options), tree_(tree) {}

  double uniform_angle(std::span<const Neighbor> neighbors, double alpha0_rad) const;
  double mingling(std::span<const Neighbor> neighbors) const;
  double dominance(std::span<const Neighbor> neighbors) const;
  double crowding(std::span<const Neighbor> neighbors) const;
  double crown_overlap(std::span<const Neighbor> neighbors) const;
  double differentiation(std::span<const Neighbor> neighbors) const;
  double hegyi(std::span<const Neighbor> neighbors) const;

 private:
  double reach_m(const Neighbor& neighbor) const;

  const Inventory& inventory_;
  const StructuralUnitOptions& options_;
  std::size_t tree_;
};

/// The sizes that U and T compare; empty if the inventory has none.
const std::vector<double>& sizes_of(const Inventory& inventory, SizeMeasure measure);

/// Area that two circles share [m2].
double shared_area_m2(double radius_m, double other_radius_m, double distance_m);

}  // namespace silvafit::stand
