// SPDX-License-Identifier: MIT
// Whether sizes of trees, in whole columns or in some plots, are in another unit than cm and m.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {

/// Medians of h/dbh, both in the same unit, of real stands; single trees have 15 to 300.
inline constexpr double kLowestUsualSlenderness = 25.0;
inline constexpr double kHighestUsualSlenderness = 140.0;

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

using PlaceOfRow = std::function<Place(std::size_t row)>;

/// Refuses positions in another unit than meters, such as degrees, by the trees and the basal area
/// in the bounding rectangles of plots: the densest known forests have about 450 m2/ha.
/// \param columns  of x and y, for the message
/// \throws InputError
void check_crowding(const Inventory& inventory, const std::string& columns);

/// A column of sizes of trees.
struct SizeColumn {
  std::string_view name{};           ///< dbh, h, hcb, cw, cr_e, cr_w, cr_s or cr_n
  std::string source{};              ///< column or expression of the file, ready for a conversion
  std::span<const double> values{};  ///< (N), NaN where missing
};

/// Refuses tables of trees some of whose plots or species, or whole columns, have another unit.
/// Plots are compared by find_mixed_units(). Medians of columns, and of those of each species, are
/// judged by what stands of trees can have: limits of sizes, and the height at which a stem of the
/// dbh buckles under its own weight, 95 (dbh/m)^(2/3) m (McMahon 1973, Science 179: 1201-1204, from
/// which no tree of 576 is higher); palms reach a quarter more (Rich 1986). Also refuses dbh and h
/// of a whole table that are exchanged: heights vary less than diameters, and the stand would be
/// more usual the other way round, values that may be codes (data::possible_code()), and sizes that
/// no tree has.
///
/// \param plot, species  (N); empty: unknown
/// \param place_of       of a row
/// \throws InputError with the conversions that make plausible trees
void check_units_of_trees(const data::TextColumn& plot,
                          const data::TextColumn& species,
                          const std::vector<SizeColumn>& columns,
                          const std::string& file,
                          const PlaceOfRow& place_of);

}  // namespace silvafit::stand
