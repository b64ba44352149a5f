// SPDX-License-Identifier: MIT
// Plots of one file that were written in other units than the others.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::stand {

/// Trees as far as the question needs them.
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
  double slenderness_of_others = 0.0;  ///< of the plots that are right
};

/// Finds plots of another unit by their median h/dbh, as far as other plots of the file have a
/// usual one (25 to 140): h/dbh must be unusual as it is; the unit must bring their trees to the
/// heights that trees of the same species and dbh have in the other plots; and without it these
/// heights must be missed by far. Plots with fewer than three trees of known dbh and h are not
/// judged.
std::vector<MixedUnits> find_mixed_units(const TreeSizes& trees);

/// The finding in words, with the plots and the remedy; empty if there is none.
std::string describe_mixed_units(const std::vector<MixedUnits>& mixed);

}  // namespace silvafit::stand
