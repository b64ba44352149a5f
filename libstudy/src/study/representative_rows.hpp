// SPDX-License-Identifier: MIT
// Samples of large tables.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// About this many rows of a table that represent all, ascending.
///
/// Every group has the same maximum share, but at least 40 rows if it has them; the
/// selected rows are evenly spaced over its rows by dbh, or by their order without that column. If
/// there are still too many, every second, third ... group is used. No random
/// numbers.
std::vector<std::size_t> representative_rows(const data::Table& table,
                                             const std::string& group,
                                             std::size_t wanted);

}  // namespace silvafit::study
