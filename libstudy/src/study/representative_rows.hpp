// SPDX-License-Identifier: MIT
// Samples of large tables.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::study {

/// About so many rows of a table that represent all, ascending.
///
/// Every group has the same share at most, but not fewer than 40 rows where it has them; what is
/// taken of it is spread evenly over its rows by dbh, or by their order without that column. If
/// the groups together still have too many, every second, third ... group is taken. No random
/// numbers.
std::vector<std::size_t> representative_rows(const data::Table& table,
                                             const std::string& group,
                                             std::size_t wanted);

}  // namespace silvafit::study
