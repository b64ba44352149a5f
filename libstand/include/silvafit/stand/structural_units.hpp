// SPDX-License-Identifier: MIT
// Structural units: a tree and its nearest neighbors, and what they say about its surroundings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/plot_windows.hpp"
#include "silvafit/stand/unit_findings.hpp"
#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// How trees near the boundary are treated, whose true neighbors may stand outside.
enum class EdgeCorrection {
  kNone,     ///< every tree inside the window is a core tree
  kBuffer,   ///< trees nearer than buffer_m to the boundary serve as neighbors only
  kHanisch,  ///< core trees are those whose n-th neighbor is nearer than the boundary, weighted by
             ///< the inverse of their chance to be so
  kTorus,    ///< opposite sides of a rectangular window are joined
};

/// The size that trees are compared by in U and T.
enum class SizeMeasure { kDbh, kHeight, kCrownWidth };

/// How far a crown reaches towards another in C.
enum class CrownReach {
  kMeanWidth,    ///< half the crown width
  kFacingRadii,  ///< the radius towards the other stem, on the quarter ellipse between two of the
                 ///< four measured radii
};

/// Indices beyond W, M, U and C; structural_units computes those that are asked for.
enum class FurtherIndex {
  kCrownOverlap,  ///< CO: mean share of the own crown that a neighbor's covers, crowns as circles
  kDifferentiation,   ///< T: mean of 1 - smaller size / larger size
  kHegyi,             ///< Hegyi: sum of (dbh_j / dbh_i) / distance [1/m]
  kBasalAreaLarger,   ///< BAL: basal area of the trees with larger dbh [m2/ha]
  kCrownCompetition,  ///< CCF: crown area of open-grown trees of the same dbh [% of the area]
};

/// CO, T, Hegyi, BAL or CCF.
std::string_view name_of(FurtherIndex index);
/// The index of that name; none if there is no such one.
std::optional<FurtherIndex> further_index_named(std::string_view name);
/// All of them, in the order above.
std::span<const FurtherIndex> all_further_indices();

struct StructuralUnitOptions {
  std::size_t neighbors = 4;           ///< n, 1 to 64
  std::optional<double> alpha0_deg{};  ///< limit angle of W; default 360 / (n + 1), 72 for n = 4
  /// Limit angles of reference trees of some species, in place of alpha0_deg.
  std::vector<std::pair<std::string, double>> alpha0_deg_of_species{};
  /// The inventory is a part of one: such a species may stand in another part
  /// (check_species_of_angles), and what there is to say is said of all parts (notes_of).
  bool is_part = false;
  EdgeCorrection edge = EdgeCorrection::kBuffer;
  double buffer_m = 5.0;  ///< >= 0
  SearchScope scope = SearchScope::kPlot;
  /// Windows that were given. Without any, the convex hull (for a torus the bounding rectangle) of
  /// each plot (kPlot) or of the stand (kStand) is taken and a note says so.
  std::vector<NamedWindow> windows{};
  SizeMeasure size = SizeMeasure::kDbh;
  CrownReach reach = CrownReach::kMeanWidth;
  std::vector<FurtherIndex> further{};
  /// Hegyi's competitors: trees not farther than this; 0: the n neighbors.
  double competition_radius_m = 0.0;
  /// Area of every plot, which BAL and CCF count by where no window is given: of all its trees.
  /// Else their area is that of the windows, or of the convex hulls, which a note says.
  std::optional<double> plot_area_m2{};
  /// CCF's crown width of an open-grown tree [m], an expression of dbh [cm] and other columns.
  std::string open_grown_crown{};
  unsigned threads = 0;  ///< 0: as many as there are cores
};

/// The index of a neighbor that does not exist.
inline constexpr std::uint32_t kNoTree = 0xffffffffU;

/// Values of a further index.
struct FurtherValues {
  FurtherIndex index{};
  std::vector<double> values{};  ///< (N), NaN where it cannot be known
};

/// The structural units of N trees with n neighbors each.
///
/// W (uniform angle index): share of the n angles between neighbors adjacent in azimuth, each taken
/// <= 180 degrees, that are smaller than alpha0. M (mingling): share of neighbors of another
/// species. U (dominance): share of neighbors whose DBH is not smaller. C (crowding): share of
/// neighbors whose crown overlaps, (cw_i + cw_j) / 2 > distance. All are 0, 1/n, ..., 1, or NaN
/// where they cannot be known; docs/structural-units.md has every rule.
/// Source: Hui and Gadow 2002 (W); Gadow and Fueldner 1993 (M); Gadow and Hui 2002 (U); Hu and Hui
/// 2015 (C); Gadow 1993 (T); Hegyi 1974; Wykoff 1990 (BAL); Krajicek and others 1961 (CCF).
struct StructuralUnits {
  std::size_t neighbors = 0;  ///< n
  SearchScope scope = SearchScope::kPlot;
  double alpha0_deg = 0.0;
  EdgeCorrection edge = EdgeCorrection::kNone;
  double buffer_m = 0.0;         ///< of EdgeCorrection::kBuffer
  PlotWindows windows{};         ///< no domains where none was needed
  std::vector<char> core{};      ///< (N) 1 for trees whose unit counts, 0 for neighbors only
  std::vector<double> weight{};  ///< (N) of core trees in means (kHanisch); none: all count alike
  std::vector<double> W{};       ///< (N)
  std::vector<double> M{};       ///< (N)
  std::vector<double> U{};       ///< (N)
  std::vector<double> C{};       ///< (N); none if the inventory has no crown widths
  std::vector<FurtherValues> further{};  ///< those asked for
  std::vector<std::uint32_t>
      nearest{};                     ///< (N x n) rows of the neighbors, nearest first, or kNoTree
  std::vector<double> distance_m{};  ///< (N x n), NaN where there is no neighbor
  UnitFindings findings{};           ///< what there is to say
  std::vector<std::string> notes{};  ///< the same in words; none for a part of an inventory

  /// Weight of a tree in means over core trees; 0 if it is none.
  double weight_of(std::size_t tree) const {
    if (core[tree] == 0) return 0.0;
    return weight.empty() ? 1.0 : weight[tree];
  }
};

/// Computes the structural unit of every tree.
/// \throws UsageError if an option is out of range, the inventory lacks what an index needs, or a
///         torus has no rectangular window; InputError if a plot has no window or all trees are
///         outside theirs
/// Deterministic: the same values whatever the number of threads or the order of the rows.
/// Cost: n log n, also where stems stand at one place.
StructuralUnits structural_units(const Inventory& inventory, const StructuralUnitOptions& options);

/// Whether the species with limit angles of their own are among some species. Once, after the parts
/// of an inventory (StructuralUnitOptions::is_part); without parts structural_units does it.
/// \param file  for the message
/// \throws UsageError if one is not
void check_species_of_angles(const StructuralUnitOptions& options,
                             const std::vector<std::string>& species,
                             const std::string& file);

/// Writes the units as CSV: plot, tree, species, core, W, M, U, C, nn1 ... (tree ids, nearest
/// first), d1 ... [m], weight if there is one, then the further indices; missing values are empty.
/// Where neighbors come from all plots and tree ids repeat between plots, nn holds `plot-tree`.
/// \param with_header  false to continue a file
void write_structural_units(const Inventory& inventory,
                            const StructuralUnits& units,
                            std::ostream& stream,
                            bool with_header = true);

}  // namespace silvafit::stand
