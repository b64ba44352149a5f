// SPDX-License-Identifier: MIT
// Whether increments between two visits of a plot can be right.
#pragma once

#include <string>

#include "silvafit/stand/growth.hpp"

namespace silvafit::stand {

/// More than any tree grows: the fastest young plantations (balsa, paulownia, falcataria) reach 5
/// to 8 cm of dbh in a year.
inline constexpr double kFastestCmPerYear = 10.0;

/// Refuses visits of a plot in different units.
/// \param file  of the inventory, for the message
/// \throws InputError if the median tree of a plot, of three survivors or more, grew by more than
///   kFastestCmPerYear or lost a quarter of it
void check_increments(const GrowthReport& report, const std::string& file);

}  // namespace silvafit::stand
