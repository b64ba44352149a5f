// SPDX-License-Identifier: MIT
// The nearest neighbors of trees; ties are decided by a rule instead of rounding errors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

struct Neighbor {
  std::uint32_t tree = 0;
  double distance_m = 0.0;
  double east_m = 0.0;  ///< from the tree to the neighbor; on a torus to its nearest image
  double north_m = 0.0;
};

/// Smaller differences of distances are ties: positions are known to a centimeter at best, and
/// arithmetic with coordinates has errors of less than half of this up to 2e7 m, the distance
/// between the poles.
inline constexpr double kSameDistanceMeters = 1e-7;

/// A rectangle whose opposite sides are joined.
struct Torus {
  Point low{};
  Point high{};
};

/// Trees that may be each other's neighbors.
///
/// Trees at the same position (in one cell of 5e-8 m) are stored as one site, in order: a search
/// reads only as many of them as it needs, so that a million stems at one position are possible.
class NeighborSearch {
 public:
  /// Order of trees at the same distance.
  using Before = std::function<bool(std::uint32_t, std::uint32_t)>;
  /// Reusable memory of searches; one per thread.
  struct Scratch {
    std::vector<std::uint32_t> sites{};
    std::vector<double> squares{};
  };

  /// \param trees      rows of the trees among which neighbors are searched
  /// \param positions  of all rows
  /// \param torus      trees must be inside; a neighbor counts once, at its shortest distance
  NeighborSearch(std::vector<std::uint32_t> trees,
                 std::span<const Point> positions,
                 Before before,
                 std::optional<Torus> torus = std::nullopt);
  ~NeighborSearch();
  NeighborSearch(NeighborSearch&&) noexcept;
  NeighborSearch& operator=(NeighborSearch&&) noexcept;

  /// The trees, ordered such that trees that are close in space are close in the list.
  const std::vector<std::uint32_t>& trees() const;

  /// The nearest neighbors of the tree at an index of trees(), nearest first; ties with the first
  /// of them are in their order; fewer than `count` if there are no more. Thread safe.
  void nearest(std::size_t position,
               std::size_t count,
               std::vector<Neighbor>& found,
               Scratch& scratch) const;

  /// All trees not farther than a radius, in the order of `nearest`; on a torus the radius must be
  /// at most half of its shorter side.
  void within(std::size_t position, double radius_m, std::vector<Neighbor>& found) const;

 private:
  struct Index;
  std::unique_ptr<Index> index_;
};

}  // namespace silvafit::stand
