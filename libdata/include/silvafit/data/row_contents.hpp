// SPDX-License-Identifier: MIT
// Finds rows of a table that are equal in all columns.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// The content of a row with a further field, from that of the fields before it (0 for none). Rows
/// with other fields have another content but for one in 2^64.
std::uint64_t content_with(std::uint64_t content, std::string_view field);

/// (N) the contents of rows. Missing values are equal, and so are 0 and -0.
std::vector<std::uint64_t> row_contents(const Table& table);

}  // namespace silvafit::data
