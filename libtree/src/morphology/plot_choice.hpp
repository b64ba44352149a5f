// SPDX-License-Identifier: MIT
// The plots that are chosen of a table.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::tree {

/// Makes sure that each chosen plot has a row.
/// \param labels  the plots of the rows
/// \param file    for messages
/// \throws InputError that names the first plot without a row, and some of those that there are
void require_plots(const std::vector<std::string>& chosen,
                   const data::TextColumn& labels,
                   const std::string& file);

}  // namespace silvafit::tree
