// SPDX-License-Identifier: MIT
// Checks of the rows and of the whole columns of an inventory.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "trees/inventory_columns.hpp"

namespace silvafit::stand {

using Measures = std::array<double, kMeasureCount>;

/// The limits of whole columns are far outside the range of real stands, so that giants and
/// saplings pass; a single unusual value gives a note, not an error.
inline constexpr std::size_t kEnoughTrees = 10;

/// A rule that a row violates.
struct Problem {
  std::size_t measure = 0;
  std::string reason{};
};

/// Crown width from four radii; NaN if one is missing.
double crown_width_m(const Measures& row);

/// The rules that a row's measures violate; NaN: missing.
/// \param is_cw_from_radii  cw was computed from the radii, which the message then names
std::vector<Problem> problems_of(const Measures& row,
                                 bool needs_coordinates,
                                 bool is_cw_from_radii);

/// Throws if a whole column seems to have another unit.
/// \param crown_base_above_top  how many rows were left out because hcb is not below h
/// \throws InputError with the remedy
void check_units(const Inventory& inventory,
                 const ColumnPlan& plan,
                 std::size_t crown_base_above_top);

}  // namespace silvafit::stand
