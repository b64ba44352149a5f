// SPDX-License-Identifier: MIT
// Competition indices without distances: they depend on all trees of the area.
#pragma once

#include <string_view>
#include <vector>

#include "silvafit/stand/plot_windows.hpp"

namespace silvafit::stand {

inline constexpr double kSquareMetersPerHectare = 1e4;

/// Basal area of a stem [m2].
double basal_area_m2(double dbh_cm);

/// For each tree, the basal area of the trees of the same area with larger dbh [m2/ha]; equal ones
/// do not count. NaN for trees without an area.
std::vector<double> basal_area_of_larger(const Inventory& inventory,
                                         const std::vector<SampledArea>& areas);

/// For each tree, the crown competition factor of its area [%]; NaN for trees without an area.
/// \param open_grown_crown  crown width [m] as an expression of the inventory's columns
/// \throws UsageError if it is empty, uses an unknown column, or is anywhere below 0 or not
/// finite
std::vector<double> crown_competition(const Inventory& inventory,
                                      const std::vector<SampledArea>& areas,
                                      std::string_view open_grown_crown);

}  // namespace silvafit::stand
