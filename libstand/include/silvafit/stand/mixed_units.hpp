// SPDX-License-Identifier: MIT
// Plots of a file whose values have other units than those of the other plots.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// The values of trees that the search for other units needs.
struct TreeSizes {
  const data::TextColumn& plot;
  const data::TextColumn* species = nullptr;  ///< none: all trees are compared with each other
  std::span<const double> dbh_cm{};           ///< (N), NaN where missing
  std::span<const double> h_m{};              ///< (N), NaN where missing
};

/// Plots whose sizes are in another unit.
struct MixedUnits {
  std::string dbh_unit{};  ///< mm or in; empty if dbh is right
  std::string h_unit{};    ///< dm, cm or ft; empty if h is right
  std::vector<std::string> plots{};
  double slenderness = 0.0;            ///< median h/dbh of these plots, both in the same unit
  double slenderness_of_others = 0.0;  ///< of the plots in the expected units
};

/// Finds plots in another unit by their median h/dbh, if other plots of the file have a usual one
/// (25 to 140). Three conditions hold for such a plot: its h/dbh is unusual as written; with the
/// other unit, its heights are near those of trees with the same species and dbh in the other
/// plots; without it, they are far from them. Plots with fewer than three trees of known dbh and h
/// are not tested.
std::vector<MixedUnits> find_mixed_units(const TreeSizes& trees);

/// A message with the plots and the remedy; empty if there are no such plots.
std::string describe_mixed_units(const std::vector<MixedUnits>& mixed);

}  // namespace silvafit::stand
