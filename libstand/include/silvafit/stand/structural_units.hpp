// SPDX-License-Identifier: MIT
// Structural units: a tree and its nearest neighbors, and the indices that describe them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/plot_windows.hpp"
#include "silvafit/stand/unit_findings.hpp"
#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// Edge correction for trees near the boundary, whose true neighbors may be outside.
enum class EdgeCorrection {
  kBuffer,   ///< trees nearer than buffer_m to the boundary are used only as neighbors
  kHanisch,  ///< core trees are those whose n-th neighbor is nearer than the boundary, weighted by
             ///< the inverse of their probability of being core trees
  kTorus,    ///< opposite sides of a rectangular window are joined
  kNone,     ///< every tree inside the window is a core tree
};
constexpr std::array<std::string_view, 4> words_of(EdgeCorrection /*edge*/) {
  return {"buffer", "hanisch", "torus", "none"};
}

/// The size that U and T compare.
enum class SizeMeasure { kDbh, kHeight, kCrownWidth };
constexpr std::array<std::string_view, 3> words_of(SizeMeasure /*size*/) {
  return {"dbh", "h", "cw"};
}

/// The reach of a crown towards another crown in C.
enum class CrownReach {
  kMeanWidth,    ///< half the crown width
  kFacingRadii,  ///< the radius towards the other stem, on the quarter ellipse between two of the
                 ///< four measured radii
};
constexpr std::array<std::string_view, 2> words_of(CrownReach /*reach*/) {
  return {"mean", "facing"};
}

/// Indices besides W, M, U and C; structural_units computes those that are requested.
enum class FurtherIndex {
  kCrownOverlap,      ///< CO: mean proportion of the tree's crown circle that a neighbor's covers
  kDifferentiation,   ///< T: mean of 1 - smaller size / larger size
  kHegyi,             ///< Hegyi: sum of (dbh_j / dbh_i) / distance [1/m]
  kBasalAreaLarger,   ///< BAL: basal area of the trees with larger dbh [m2/ha]
  kCrownCompetition,  ///< CCF: crown area of open-grown trees of the same dbh [% of the area]
};

constexpr std::array<std::string_view, 5> words_of(FurtherIndex /*index*/) {
  return {"CO", "T", "Hegyi", "BAL", "CCF"};
}

struct StructuralUnitOptions {
  std::size_t neighbors = 4;           ///< n, 1 to 64
  std::optional<double> alpha0_deg{};  ///< limit angle of W; default 360 / (n + 1), 72 for n = 4
  /// Limit angles for some species of the reference tree, instead of alpha0_deg.
  std::vector<std::pair<std::string, double>> alpha0_deg_of_species{};
  /// The inventory is a part of a larger one: such a species may occur in another part
  /// (check_species_of_angles), and notes are written for all parts together (notes_of).
  bool is_part = false;
  EdgeCorrection edge = EdgeCorrection::kBuffer;
  double buffer_m = 5.0;  ///< >= 0
  SearchScope scope = SearchScope::kPlot;
  /// Given windows. Without any, the convex hull (for a torus the bounding rectangle) of each plot
  /// (kPlot) or of the stand (kStand) is used, with a note.
  std::vector<NamedWindow> windows{};
  SizeMeasure size = SizeMeasure::kDbh;
  CrownReach reach = CrownReach::kMeanWidth;
  std::vector<FurtherIndex> further{};
  /// Hegyi's competitors: trees not farther than this; 0: the n neighbors.
  double competition_radius_m = 0.0;
  /// Area of every plot, used by BAL and CCF if no window is given: that of all its trees.
  /// Otherwise the area is that of the windows, or of the convex hulls, with a note.
  std::optional<double> plot_area_m2{};
  /// Plots of a sampling design with their counted trees, used by BAL and CCF. `windows` are then
  /// circles of complete neighborhoods: plots may lack one, and all trees may be outside.
  std::optional<std::vector<SampledArea>> sampled{};
  /// CCF's crown width of an open-grown tree [m], an expression of dbh [cm] and other columns.
  std::string open_grown_crown{};
  unsigned threads = 0;  ///< 0: one for each core
};

/// The index of a neighbor that does not exist.
inline constexpr std::uint32_t kNoTree = 0xffffffffU;

/// Values of a further index.
struct FurtherValues {
  FurtherIndex index{};
  std::vector<double> values{};  ///< (N), NaN if unknown
};

/// The structural units of N trees with n neighbors each.
///
/// W (uniform angle index): proportion of the n angles between neighbors adjacent in azimuth, each
/// <= 180 degrees, that are smaller than alpha0. M (mingling): proportion of neighbors of another
/// species. U (dominance): proportion of neighbors whose DBH is not smaller. C (crowding): that of
/// neighbors whose crown overlaps, (cw_i + cw_j) / 2 > distance. All are 0, 1/n, ..., 1, or NaN if
/// unknown; docs/structural-units.md defines special cases.
/// Source: Hui and Gadow 2002 (W); Gadow and Fueldner 1993 (M); Gadow and Hui 2002 (U); Hu and Hui
/// 2015 (C); Gadow 1993 (T); Hegyi 1974; Wykoff 1990 (BAL); Krajicek and others 1961 (CCF).
struct StructuralUnits {
  std::size_t neighbors = 0;  ///< n
  SearchScope scope = SearchScope::kPlot;
  double alpha0_deg = 0.0;
  EdgeCorrection edge = EdgeCorrection::kNone;
  double buffer_m = 0.0;         ///< of EdgeCorrection::kBuffer
  PlotWindows windows{};         ///< empty if no window was needed
  std::vector<char> core{};      ///< (N) 1 for core trees, 0 for trees used only as neighbors
  std::vector<double> weight{};  ///< (N) of core trees in means (kHanisch); none: equal weights
  std::vector<double> W{};       ///< (N)
  std::vector<double> M{};       ///< (N)
  std::vector<double> U{};       ///< (N)
  std::vector<double> C{};       ///< (N); none if the inventory has no crown widths
  std::vector<FurtherValues> further{};  ///< the requested ones
  std::vector<std::uint32_t>
      nearest{};                     ///< (N x n) rows of the neighbors, nearest first, or kNoTree
  std::vector<double> distance_m{};  ///< (N x n), NaN where there is no neighbor
  UnitFindings findings{};           ///< findings for the notes
  std::vector<std::string> notes{};  ///< the notes as text; none for a part of an inventory

  /// Weight of a tree in means over core trees; 0 if it is not a core tree.
  double weight_of(std::size_t tree) const {
    if (core[tree] == 0) return 0.0;
    return weight.empty() ? 1.0 : weight[tree];
  }
};

/// Computes the structural unit of every tree.
/// \throws UsageError if an option is out of range, the inventory lacks a column for an index, or a
///         torus has no rectangular window; InputError if a plot has no window or all trees are
///         outside their windows
/// Deterministic: the number of threads and the order of the rows do not change the values.
/// Cost: n log n, also if stems have the same position.
StructuralUnits structural_units(const Inventory& inventory, const StructuralUnitOptions& options);

/// Checks that the species with limit angles of their own occur among the given ones, after all
/// parts of an inventory (StructuralUnitOptions::is_part); without parts structural_units does it.
/// \param file  for the message
/// \throws UsageError if one does not occur
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

/// The same rows one by one, for callers that choose or order them.
/// \param ids_repeat  whether tree ids repeat between plots, if other parts have more plots;
///                    none: as in this inventory
using UnitRowSink = std::function<void(std::size_t tree, std::string_view text)>;
void write_structural_units(const Inventory& inventory,
                            const StructuralUnits& units,
                            const UnitRowSink& sink,
                            std::optional<bool> ids_repeat = std::nullopt);
/// The header of these rows, with its line end.
std::string header_of_units(const StructuralUnits& units);

}  // namespace silvafit::stand
