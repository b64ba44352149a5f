// SPDX-License-Identifier: MIT
// Stand values per hectare, by plot, by stratum and in total.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/plot_windows.hpp"

namespace silvafit::stand {

/// Values of an area. NaN if unknown: no tree, no heights, no crowns. Trees count as many times as
/// they represent others (Inventory::represented), also in means and standard deviations.
struct StandFigures {
  std::size_t trees = 0;
  double area_ha = 0.0;
  double stems_per_ha = 0.0;
  double basal_area_m2_per_ha = 0.0;
  double mean_dbh_cm = 0.0;
  double sd_dbh_cm = 0.0;  ///< with n - 1, as the other standard deviations
  double quadratic_mean_dbh_cm = 0.0;
  double mean_height_m = 0.0;  ///< of the trees with a height
  double sd_height_m = 0.0;
  double lorey_height_m = 0.0;  ///< mean height weighted by basal area
  double dominant_height_m = 0.0;
  double dominant_lorey_height_m = 0.0;  ///< of the dominant trees, weighted by basal area
  double dominant_dbh_cm = 0.0;          ///< quadratic mean of the dominant trees
  /// Sum of crown areas (circles of cw) over the area; of the trees with a crown width.
  double crown_cover_percent = 0.0;
  /// Sums of Inventory::quantities over the area, of the trees that have them.
  std::vector<double> quantities_per_ha{};
  std::vector<std::size_t> trees_without_quantity{};
  std::size_t trees_without_crown_width = 0;
  std::size_t dominant_trees = 0;                 ///< number of trees in the dominant height
  std::size_t dominant_trees_without_height = 0;  ///< of these
};

/// Dominant height is the mean height of a number of thickest trees per hectare (at least one tree;
/// all trees if there are fewer); of equally thick trees the taller ones. Trees among them without
/// height are not in the mean.
StandFigures stand_figures(const Inventory& inventory,
                           std::span<const std::size_t> trees,
                           double area_m2,
                           double dominant_trees_per_ha = 100.0);

/// A note with the number of trees missing in the crown cover; empty if none, or if it is unknown.
std::string note_on_crown_cover(const StandFigures& figures);

/// A class of diameters, from low (included) to high.
struct DiameterClass {
  double low_cm = 0.0;
  double high_cm = 0.0;
  std::size_t trees = 0;
  double stems_per_ha = 0.0;
  double basal_area_m2_per_ha = 0.0;
};

/// Classes of one width, starting at 0, from the first to the last class with a tree.
/// \throws UsageError if the width is not above 0, or would make more than 10,000 classes
std::vector<DiameterClass> diameter_distribution(const Inventory& inventory,
                                                 std::span<const std::size_t> trees,
                                                 double area_m2,
                                                 double width_cm);

/// A mean per hectare over plots and its standard error, and the total of a stratum.
struct Estimate {
  double per_ha = 0.0;
  double standard_error = 0.0;  ///< NaN for one plot
  double total = 0.0;           ///< NaN unless the stratum's area is known
  double total_standard_error = 0.0;
};

/// A mean over the trees of a population.
struct Mean {
  double value = 0.0;           ///< NaN without trees
  double standard_error = 0.0;  ///< NaN for one plot
};

/// Plots of one stratum, or of all.
struct StratumFigures {
  enum class Kind {
    kStratum,
    kWithout,  ///< the plots without a stratum
    kAll,      ///< all together
  };
  Kind kind = Kind::kStratum;
  std::string name{};  ///< of a stratum, else empty
  std::size_t plots = 0;
  std::size_t trees = 0;
  double sampled_ha = 0.0;
  double area_ha = 0.0;  ///< of the stratum; NaN if not given
  Estimate stems{};
  Estimate basal_area_m2{};
  std::vector<Estimate> quantities{};      ///< of Inventory::quantities
  std::vector<Mean> quantities_of_tree{};  ///< their means over the trees that have them
  Mean mean_height_m{};
  Mean quadratic_mean_dbh_cm{};
};

/// How variances of strata are estimated.
struct StratumSettings {
  /// Strata were made after plots were chosen from all strata together (post-stratification), so
  /// that their numbers of plots are random.
  bool are_posterior = false;
  /// Estimation units, within each of which posterior strata were made and plots were chosen; empty
  /// names and no entries: one for all strata.
  std::map<std::string, std::string> unit_of_stratum{};
  /// Plots are a considerable part of their strata, whose areas are known: the variance of a
  /// stratum is multiplied by the share of its area that is not in a plot.
  bool is_finite = false;
};

/// Estimates by stratum and, last, for all together.
///
/// Plots are a simple random sample of their stratum. Per hectare: the ratio R = sum y / sum a of
/// the plots' values and areas; standard error sqrt(sum (y - R a)^2 / (n (n - 1))) / mean a,
/// which is that of the mean if plots are equal (Cochran 1977, chapter 6). Over strata:
/// weighted by their areas if all are known (chapter 5), else all plots are one sample. Means over
/// trees are ratios of two such totals, sum of heights to number of trees with a height, with the
/// standard error of the combined ratio (chapter 6.11), which is that of the total of y - R x
/// divided by the total of x; for the quadratic mean diameter with the first term of a Taylor
/// series. Plots without a stratum have an entry of their own after the strata, and are not in the
/// values of all that are weighted by areas.
/// \param stratum_of_area   the stratum of each area, empty if it has none; no entries: no strata,
///                          and the result is one entry
/// \param stratum_areas_ha  areas by name; may be empty
/// \param are_weights       they are relative areas, which give no totals
/// \throws UsageError if an area is given for an unknown stratum, or not for all strata, or
///   `settings` need areas of strata that are not given, or are smaller than those of the plots
std::vector<StratumFigures> stratum_figures(const Inventory& inventory,
                                            const std::vector<SampledArea>& areas,
                                            const std::vector<std::string>& stratum_of_area,
                                            const std::map<std::string, double>& stratum_areas_ha,
                                            bool are_weights = false,
                                            const StratumSettings& settings = {});

/// Trees of one kind, such as a species and diameter class.
struct DomainFigures {
  std::vector<std::string> labels{};  ///< in the order of StandReportOptions::by; may be empty
  StratumFigures figures{};           ///< of all strata together
};

}  // namespace silvafit::stand
