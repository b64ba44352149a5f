// SPDX-License-Identifier: MIT
// Selection of plots of a table.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::tree {

/// Checks that each chosen plot has a row.
/// \param labels  the plots of the rows
/// \param file    for messages
/// \throws InputError that names the first plot without a row, and some existing ones
void require_plots(const std::vector<std::string>& chosen,
                   const data::TextColumn& labels,
                   const std::string& file);

}  // namespace silvafit::tree
