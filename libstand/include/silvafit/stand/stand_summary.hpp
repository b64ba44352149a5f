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

/// Trees of one kind, such as a species and diameter class.
struct DomainFigures {
  std::vector<std::string> labels{};  ///< in the order of StandReportOptions::by; may be empty
  StratumFigures figures{};           ///< of all strata together
};

}  // namespace silvafit::stand
