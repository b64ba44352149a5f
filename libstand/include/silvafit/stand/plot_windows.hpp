// SPDX-License-Identifier: MIT
// The window of each plot of an inventory.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// Where neighbors are searched.
enum class SearchScope {
  kPlot,   ///< among the trees of the same plot
  kStand,  ///< among all trees
};
constexpr std::array<std::string_view, 2> words_of(SearchScope /*scope*/) {
  return {"plot", "stand"};
}

/// The window that is used if none is given.
enum class AssumedWindow {
  kConvexHull,  ///< the smallest convex polygon around the trees
  kRectangle,   ///< the rectangle around the trees, parallel to x and y, for a torus
};

/// An area whose trees are counted together: a plot with a window of its own, or the stand.
struct Domain {
  std::string name{};  ///< of its plot; empty for the stand
  Window window;
};

/// The windows of the plots of an inventory. Plots without a window of their own share that of the
/// stand.
struct PlotWindows {
  std::vector<Domain> domains{};
  /// By code of Inventory::plot: the plot's domain. None if its trees have no convex hull.
  std::vector<std::optional<std::size_t>> domain_of_plot{};
  bool is_assumed = false;           ///< no window was given
  std::vector<std::string> notes{};  ///< the assumed window
  /// Plots without a convex hull: one or two trees, or all on one line. Or those without a given
  /// window that may lack one.
  std::vector<std::string> plots_without_window{};
  std::size_t plots_in_window_of_stand = 0;  ///< plots without a given window of their own

  /// The window of a tree, or nothing.
  const Window* window_of(const Inventory& inventory, std::size_t tree) const;
};

/// Gives each plot the window with its name, else that of every plot, else that of the stand;
/// without any given window, one around the trees of each plot (kPlot) or of the stand (kStand).
/// \param given  as read by read_windows
/// \param may_lack  plots may have no window although windows are given; their trees are in no
///                  domain
/// \throws InputError if windows are given and a plot has none; UsageError if neighbors are
///         searched within plots and several plots share the stand's window
PlotWindows plot_windows(const Inventory& inventory,
                         const std::vector<NamedWindow>& given,
                         SearchScope scope,
                         AssumedWindow assumed = AssumedWindow::kConvexHull,
                         bool may_lack = false);

/// \throws UsageError if several plots share the stand's window, because neighbors are searched
///         within each plot
void refuse_shared_window(std::size_t plots);

/// Whether each tree is inside its window: 1, else 0; 0 also without position or window.
std::vector<char> trees_inside(const Inventory& inventory,
                               const PlotWindows& windows,
                               unsigned threads = 0);

/// An inventoried area and the rows of the trees inside.
struct SampledArea {
  std::string name{};  ///< of its plot; empty for a stand of several plots
  double area_m2 = 0.0;
  std::optional<Window> window{};  ///< none if only the area is known
  std::vector<std::size_t> trees{};
  /// False for designs without area, such as angle counts: area_m2 is then 1 ha, or the share of it
  /// in the population.
  bool has_area = true;
  /// Area of the whole plot, of which area_m2 is the share in the population; NaN: the same.
  double whole_m2 = std::numeric_limits<double>::quiet_NaN();
};

/// The domains of the windows with their trees, in the order of the domains, then the given windows
/// of plots without rows, because plots without trees are counted, too.
std::vector<SampledArea> sampled_areas(const Inventory& inventory,
                                       const PlotWindows& windows,
                                       const std::vector<NamedWindow>& given);

/// Every plot of the inventory with one known area, for inventories without positions.
std::vector<SampledArea> sampled_areas(const Inventory& inventory, double plot_area_m2);

/// Removes areas in which no tree is counted, but living ones stand that lack a dbh or, with
/// by_position, a position: these plots are unknown, not empty.
/// \return the names of the plots
std::vector<std::string> take_unknown_plots(const Inventory& inventory,
                                            bool by_position,
                                            std::vector<SampledArea>& areas);

/// Every plot of the inventory with an unknown area, NaN: values per hectare are NaN, too.
std::vector<SampledArea> plots_of_unknown_area(const Inventory& inventory);

}  // namespace silvafit::stand
