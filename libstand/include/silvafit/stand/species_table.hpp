// SPDX-License-Identifier: MIT
// Species tables: importance values by layer, sizes, density.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/stand_summary.hpp"

namespace silvafit::stand {

/// Layers by total height. With limits 10 and 20 m: lower (below 10), middle (10 to below 20) and
/// upper (20 and more), as in Wang and others 2023.
struct Layers {
  std::vector<double> bounds_m{10.0, 20.0};  ///< ascending

  std::size_t count() const { return bounds_m.size() + 1; }
  /// Index of the layer, from 0 (lowest); count() for a tree without height.
  std::size_t layer_of(double height_m) const;
  /// lower, middle, upper; with other numbers of layers `10-20 m` and so on.
  std::string name_of(std::size_t layer) const;
};

/// Importance of a species among the trees of a layer or of all [%]; each of the four values sums
/// to 100 over the species.
struct Importance {
  double relative_density = 0.0;    ///< relative number of stems
  double relative_frequency = 0.0;  ///< number of quadrats where it occurs, relative to the sum of
                                    ///< these over the species
  double relative_dominance = 0.0;  ///< relative basal area
  double value = 0.0;               ///< mean of the three
  double plot_mean = 0.0;           ///< mean over plots of the value within the plot
  double plot_sd = 0.0;             ///< standard deviation of that value; NaN for one plot
};

/// A species, as in Table 1 of Wang and others 2023.
struct SpeciesRow {
  std::string species{};  ///< empty for trees without species
  StandFigures figures{};
  double basal_area_m2 = 0.0;  ///< of all its trees
  Importance all{};
  std::vector<Importance> layers{};  ///< by layer, from the lowest; none if there are no heights
};

struct SpeciesTableOptions {
  Layers layers{};
  /// Side of the square quadrats for the frequency; 0: the inventory's plots are the quadrats.
  double quadrat_m = 0.0;
  double dominant_trees_per_ha = 100.0;
};

/// The side of the quadrats of an inventory whose user gives none [m]: 10 in a single plot with a
/// window, else 0, the plots.
double usual_quadrat_m(bool is_only_plot, const std::vector<SampledArea>& areas);
/// "Frequency is that in quadrats of 10 m", or in plots; to be shown with importance values.
std::string describe_frequency(double quadrat_m);

/// A row for each species, by decreasing importance. Quadrats are counted from the south-west
/// corner of the window of each area; a tree on the border of two belongs to the one farther east
/// or north, on the window's own border to the last quadrat.
/// \throws UsageError if layers are not increasing, or quadrats are requested without positions
std::vector<SpeciesRow> species_table(const Inventory& inventory,
                                      const std::vector<SampledArea>& areas,
                                      const SpeciesTableOptions& options = {});

}  // namespace silvafit::stand
