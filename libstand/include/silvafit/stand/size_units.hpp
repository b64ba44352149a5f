// SPDX-License-Identifier: MIT
// Whether whole columns of sizes are in another unit than cm and m.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/stand/mixed_units.hpp"

namespace silvafit::stand {

/// A column of sizes of trees.
struct SizeColumn {
  std::string_view name{};           ///< dbh, h, hcb, cw, cr_e, cr_w, cr_s or cr_n
  std::string source{};              ///< column or expression of the file, ready for a conversion
  std::span<const double> values{};  ///< (N), NaN where missing
};

/// Refuses tables of trees some of whose plots, or whole columns, have another unit.
/// \param trees  for find_mixed_units
/// \throws InputError with the remedy
void check_units_of_trees(const TreeSizes& trees,
                          const std::vector<SizeColumn>& columns,
                          const std::string& file);

/// Judges medians by what stands of trees can have: limits of sizes, and the height at which a stem
/// of the dbh buckles under its own weight, 95 (dbh/m)^(2/3) m (McMahon 1973, Science 179:
/// 1201-1204, from which no tree of 576 is higher); palms reach a quarter more (Rich 1986). \throws
/// InputError with the conversions that make plausible trees
void check_size_units(const std::vector<SizeColumn>& columns, const std::string& file);

}  // namespace silvafit::stand
