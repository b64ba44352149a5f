// SPDX-License-Identifier: MIT
// The nearest neighbors of trees, with ties decided by rule and not by rounding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

struct Neighbor {
  std::uint32_t tree = 0;
  double distance_m = 0.0;
};

/// Distances that differ by less are ties: positions are known to a centimetre at best, and
/// arithmetic with coordinates of millions of metres errs by some 1e-9 m.
inline constexpr double kSameDistance_m = 1e-7;

/// Trees that may be each other's neighbors.
class NeighborSearch {
 public:
  /// Order of trees at the same distance.
  using Before = std::function<bool(std::uint32_t, std::uint32_t)>;

  /// \param trees      rows of the trees among which neighbors are searched
  /// \param positions  of all rows
  NeighborSearch(std::vector<std::uint32_t> trees, std::span<const Point> positions);
  ~NeighborSearch();
  NeighborSearch(NeighborSearch&&) noexcept;
  NeighborSearch& operator=(NeighborSearch&&) noexcept;

  /// The trees, ordered such that those near each other in space are near in the list.
  const std::vector<std::uint32_t>& trees() const;

  /// The nearest neighbors of the tree at a position of trees(), nearest first, ties in the order
  /// of `before`; fewer than `count` if there are no more. Thread safe.
  void nearest(std::size_t position,
               std::size_t count,
               const Before& before,
               std::vector<Neighbor>& found) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace silvafit::stand
