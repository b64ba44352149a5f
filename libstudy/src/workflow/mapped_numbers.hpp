// SPDX-License-Identifier: MIT
// The numbers of our columns in a table that may have them under other names.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// The numbers of a column, all missing if the table has none.
/// \param columns     sources of standard columns: names or expressions
/// \param unreadable  gets the cells that are no numbers, which are missing
std::vector<double> mapped_numbers(const data::Table& table,
                                   const std::map<std::string, std::string>& columns,
                                   const std::string& name,
                                   std::vector<data::TextCell>& unreadable);

}  // namespace silvafit::study
