// SPDX-License-Identifier: MIT
// Sampling designs of plots: how many trees per hectare each counted tree stands for, and where
// neighborhoods are complete.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/plot_table.hpp"
#include "silvafit/stand/plot_windows.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/window.hpp"

namespace silvafit::stand {

/// One of the concentric circles of a plot: trees from this dbh to that of the next larger circle
/// are counted up to this distance from the center.
struct CountingCircle {
  double from_dbh_cm = 0.0;
  double radius_m = 0.0;
};

/// How the trees of plots were chosen. One of circles, basal_area_factor and expansion, or the
/// areas of `plots`, which are plots of fixed area.
struct SamplingDesign {
  std::optional<PlotTable> plots{};
  std::vector<CountingCircle> circles{};  ///< dbh and radius increase
  double basal_area_factor = 0.0;         ///< of angle counts [m2/ha]; 0: none
  double smallest_dbh_cm = 0.0;           ///< of angle counts; 0: the smallest dbh of the inventory
  std::string expansion{};  ///< column of Inventory::other: trees per ha that a tree stands for
  /// Whether factors of `expansion` are per hectare of the part of the plot in the population; else
  /// they are per hectare of the whole plot, and values of the part are divided by its share.
  bool is_expansion_of_part = false;
  std::size_t subplots = 1;  ///< circles of a plot, each with the radius or radii
  std::string subplot{};     ///< column of Inventory::other with the subplot of each tree
  /// Distances were measured along the slope, so that areas are smaller by its cosine.
  bool corrects_slope = false;

  bool chooses_trees() const {
    return !circles.empty() || basal_area_factor > 0.0 || !expansion.empty();
  }
  /// Whether the design has any information.
  bool is_given() const { return chooses_trees() || plots.has_value(); }
};

/// The design for an inventory that has factors of its own (Inventory::expansion): they are used if
/// the design has neither factors nor areas.
SamplingDesign design_for(const Inventory& inventory, SamplingDesign design);

/// The plots of an inventory by their design.
struct DesignedSample {
  /// Plots with their counted trees. Areas are horizontal and only of the share in the population;
  /// 1 ha times the share for designs without area (SampledArea::has_area).
  std::vector<SampledArea> areas{};
  /// (N) Inventory::represented: trees on the area of its plot that a tree stands for.
  std::vector<double> represented{};
  /// Circles in which all trees with the smallest counted dbh were measured; none if positions or
  /// radii are unknown.
  std::vector<NamedWindow> complete_circles{};
  /// Labels of the places within which neighbors are searched, if plots consist of subplots.
  std::optional<data::TextColumn> subplot_labels{};
  std::vector<std::string> notes{};
};

/// Joins an inventory with its table of plots by name and applies the design.
///
/// A tree with the expansion factor f [1/ha] stands for f a / 10^4 trees of its plot's area a.
/// Fixed area and concentric circles: f = 10^4 / (m pi r^2) with m subplots, r the radius of the
/// tree's circle. Angle count with factor k: f = k / g, g = pi/4 dbh^2 [m2] (Bitterlich 1984), up
/// to the distance dbh / (2 sqrt(k)) (m, dbh in cm). Slope s: f / cos s if distances are not
/// horizontal. Plots of the table without trees are empty plots and are counted; those with share 0
/// have area 0. Factors of 0 are allowed.
/// Source: Kershaw and others 2017, Forest Mensuration, 5th ed., chapters 9 to 11; FIA's TPA_UNADJ.
/// \throws UsageError if the design contradicts itself or a column is missing; InputError if a
///         tree has no expansion factor, no plot of the inventory is in the table of plots, or no
///         plot has an area
DesignedSample sample_of(const Inventory& inventory, const SamplingDesign& design);

/// The inventory with the number of trees that each one represents.
Inventory with_represented(const Inventory& inventory, const DesignedSample& sample);

/// Structural units of sampled plots: the neighbors of a tree are complete only within the circle
/// of the smallest counted dbh, so that is the window; the trees of larger circles outside of it
/// are neighbors, but not core trees. If Hegyi's competitors are searched within a radius, the
/// buffer is at least that wide. Neighbors are searched within plots or subplots.
/// \throws as structural_units; UsageError if windows are given or --per is stand
StructuralUnits structural_units_of_sample(const Inventory& inventory,
                                           const DesignedSample& sample,
                                           StructuralUnitOptions options);

/// \throws InputError if areas make a basal area that no forest has
void check_density_is_possible(double basal_area_m2_per_ha, const Place& place);

/// For plots all of whose trees were counted on the whole area.
/// \param basal_area  of these trees [m2]
/// \throws InputError if a plot with trees has less than one per hectare, or less area than stems
void check_plot_density(
    const std::string& plot, double trees, double basal_area, double area_m2, const Place& place);

/// \throws UsageError if the design contradicts itself
void check_design(const SamplingDesign& design);

/// The strata of a table of plots.
struct DesignStrata {
  std::vector<std::string> stratum_of_area{};  ///< for stratum_figures
  std::map<std::string, double> sizes{};       ///< areas [ha] or weights by stratum; may be empty
  bool are_weights = false;
  std::map<std::string, std::string> unit_of_stratum{};  ///< as in StratumSettings
  std::vector<std::string> notes{};
};

/// \param column  of the trees, by which strata are asked for; empty: none
/// \throws UsageError if the table of plots has areas of other strata
void refuse_two_strata(const std::string& column, const std::optional<PlotTable>& plots);

/// The stratum of each area by the name of its plot.
/// \param sizes_ha  areas of strata that replace those of the table, if there are any
/// \throws InputError if rows of one stratum have different areas, weights or estimation units
DesignStrata strata_of_plots(const PlotTable& plots,
                             const std::vector<SampledArea>& areas,
                             const std::map<std::string, double>& sizes_ha);

}  // namespace silvafit::stand
