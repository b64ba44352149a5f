// SPDX-License-Identifier: MIT
// The visits of plots that were measured several times, of which stands are described by the last.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/repeated_trees.hpp"

namespace silvafit::stand {

/// Largest distance between two surveyed positions of one tree: errors of tape and compass are
/// decimeters, and trees are rarely nearer to each other.
inline constexpr double kResurveyMeters = 1.0;

/// Finds the rows of earlier visits, by the rule and with the errors of repeated_trees().
/// \param counts  gets the numbers of plots and rows
/// \return        for each row of an earlier visit the time of the plot's last one, else empty
std::vector<std::string> later_visits(const Inventory& inventory,
                                      const data::TextColumn& times,
                                      const TimedTrees& skipped,
                                      VisitCounts& counts);

}  // namespace silvafit::stand
