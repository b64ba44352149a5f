// SPDX-License-Identifier: MIT
// Labels of groups that mean another group in each plot or stand.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/tree_columns.hpp"

namespace silvafit::study {

/// Notes on groups of random effects whose labels recur: trees are numbered within plots, and plots
/// within stands, so that as groups they need both.
/// \param header  of the file, whose columns the table may lack
/// \param mapped  by the user
/// \param random  the random effects, as written
std::vector<std::string> describe_recurring_groups(const data::Table& table,
                                                   const std::vector<std::string>& header,
                                                   const std::vector<stand::ColumnMapping>& mapped,
                                                   const std::string& random);

}  // namespace silvafit::study
