// SPDX-License-Identifier: MIT
// The numbers of our columns in a table that may have them under other names.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// The numbers of a column, all missing if the table has none; none if a cell is no number.
/// \param columns  sources of standard columns: names or expressions
std::optional<std::vector<double>> mapped_numbers(const data::Table& table,
                                                  const std::map<std::string, std::string>& columns,
                                                  const std::string& name);

}  // namespace silvafit::study
