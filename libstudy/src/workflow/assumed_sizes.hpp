// SPDX-License-Identifier: MIT
// Trees of which only the diameter was measured, for pictures.
#pragma once

#include <map>
#include <string>

#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// Sets heights, crown bases and crown widths where they are missing, by a fixed formula of dbh.
/// \param columns  sources of standard columns; those that are completed are removed
/// \return a note with the number of trees and the formula of each; empty if nothing was missing
std::string assume_sizes(data::Table& table, std::map<std::string, std::string>& columns);

/// The labels of inventories without these columns: plot 1, and trees numbered from 1.
void assume_labels(data::Table& table, const std::map<std::string, std::string>& columns);

}  // namespace silvafit::study
