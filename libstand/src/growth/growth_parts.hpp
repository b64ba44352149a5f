// SPDX-License-Identifier: MIT
// Parts of a growth report: checks of visits and increments.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/stand/growth.hpp"
#include "trees/measured_plots.hpp"

namespace silvafit::stand {

/// More than any tree grows: the fastest young plantations (balsa, paulownia, falcataria) reach 5
/// to 8 cm of dbh in a year.
inline constexpr double kFastestCmPerYear = 10.0;

/// More than lost bark and errors of tapes, which are a few percent of dbh.
inline constexpr double kLargestLoss = 0.25;

/// \throws InputError if parts of one visit are times of their own, or no tree is followed
void check_visits(const std::vector<MeasuredPlot>& plots, const std::string& file);

/// Refuses plots whose trees have new numbers: none comes again, and the trees after that are too
/// thick to have grown since the visit before.
/// \throws InputError if there is such a plot
void refuse_new_numbers(const std::vector<MeasuredPlot>& plots, const Inventory& inventory);

/// Refuses visits of a plot in different units.
/// \param file  of the inventory, for the message
/// \throws InputError if the median tree of a plot, of three survivors or more, grew by more than
///   kFastestCmPerYear or lost more than kLargestLoss of it
void check_increments(const GrowthReport& report, const std::string& file);

/// \throws InputError if most survivors are other trees at the end of a period: of another species,
///   much thinner, or thicker than trees grow
void refuse_other_trees(const GrowthReport& report, const std::string& file);

/// The rows of survivors of a period at its start and its end.
using Survivors = std::vector<std::pair<std::size_t, std::size_t>>;

/// The note on survivors that stand farther from their earlier position than their nearest neighbor
/// did, and may be other trees; empty if there are none.
/// \param living  the living trees of all times
std::string describe_moved_trees(const Inventory& living, const std::vector<Survivors>& periods);

}  // namespace silvafit::stand
