// SPDX-License-Identifier: MIT
// Structural units: a tree and its nearest neighbors, and what they say about its surroundings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// How trees near the boundary are treated, whose true neighbors may stand outside.
enum class EdgeCorrection {
  kNone,    ///< every tree inside the window is a core tree
  kBuffer,  ///< trees nearer than buffer_m to the boundary serve as neighbors only
};

/// Where neighbors are searched.
enum class SearchScope {
  kPlot,   ///< among the trees of the same plot
  kStand,  ///< among all trees
};

struct StructuralUnitOptions {
  std::size_t neighbors = 4;           ///< n, 1 to 64
  std::optional<double> alpha0_deg{};  ///< limit angle of W; default 360 / (n + 1), 72 for n = 4
  EdgeCorrection edge = EdgeCorrection::kBuffer;
  double buffer_m = 5.0;  ///< >= 0
  SearchScope scope = SearchScope::kPlot;
  /// Windows that were given. Without any, the bounding rectangle of each plot (kPlot) or of the
  /// stand (kStand) is taken and a note says so.
  std::vector<NamedWindow> windows{};
  unsigned threads = 0;  ///< 0: as many as there are cores
};

/// The index of a neighbor that does not exist.
inline constexpr std::uint32_t kNoTree = 0xffffffffU;

/// The structural units of N trees with n neighbors each.
///
/// W (uniform angle index): share of the n angles between neighbors adjacent in azimuth, each taken
/// <= 180 degrees, that are smaller than alpha0. M (mingling): share of neighbors of another
/// species. U (dominance): share of neighbors whose DBH is not smaller. C (crowding): share of
/// neighbors whose crown overlaps, (cw_i + cw_j) / 2 > distance. All are 0, 1/n, ..., 1, or NaN
/// where they cannot be known; docs/structural-units.md has every rule.
/// Source: Hui and Gadow 2002 (W); Gadow and Fueldner 1993 (M); Gadow and Hui 2002 (U); Hu and Hui
/// 2015 (C).
struct StructuralUnits {
  std::size_t neighbors = 0;  ///< n
  SearchScope scope = SearchScope::kPlot;
  double alpha0_deg = 0.0;
  std::vector<char> core{};  ///< (N) 1 for trees whose unit counts, 0 for neighbors only
  std::vector<double> W{};   ///< (N)
  std::vector<double> M{};   ///< (N)
  std::vector<double> U{};   ///< (N)
  std::vector<double> C{};   ///< (N); none if the inventory has no crown widths
  std::vector<std::uint32_t>
      nearest{};                     ///< (N x n) rows of the neighbors, nearest first, or kNoTree
  std::vector<double> distance_m{};  ///< (N x n), NaN where there is no neighbor
  std::vector<std::string> notes{};  ///< what was assumed and what could not be computed
};

/// Computes the structural unit of every tree.
/// \throws UsageError if an option is out of range or the inventory has no coordinates;
///         InputError if a plot has no window or all trees are outside theirs
/// Deterministic: the same values whatever the number of threads or the order of the rows.
StructuralUnits structural_units(const Inventory& inventory, const StructuralUnitOptions& options);

/// Writes the units as CSV: plot, tree, species, core, W, M, U, C, nn1 ... (tree ids, nearest
/// first), d1 ... [m]; missing values are empty. Where neighbors come from all plots and tree ids
/// repeat between plots, nn holds `plot-tree`.
void write_structural_units(const Inventory& inventory,
                            const StructuralUnits& units,
                            std::ostream& stream);

}  // namespace silvafit::stand
