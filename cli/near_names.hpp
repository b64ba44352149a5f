// SPDX-License-Identifier: MIT
// Suggestions for unknown names.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::cli {

/// The number of letters to insert, delete or replace, and of neighboring letters to swap, that
/// changes one text to the other (the optimal string alignment distance).
std::size_t slips_between(std::string_view one, std::string_view other);

/// The most similar of the names if it is similar enough for a suggestion; else empty.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

/// Whether two names differ by one typing error, such as dhb and dbh. Names of one or two letters
/// are always similar, so the result is false for them.
bool is_slip_of(std::string_view name, std::string_view meant);

}  // namespace silvafit::cli
