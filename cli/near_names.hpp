// SPDX-License-Identifier: MIT
// Suggestions for unknown names.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::cli {

/// Letters to insert, leave out or replace, and neighboring letters to swap, so that one text
/// becomes the other (the optimal string alignment distance).
std::size_t slips_between(std::string_view one, std::string_view other);

/// The most similar of the names if it is similar enough for a suggestion; else empty.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

/// Whether a name is one slip away from another, as dhb is from dbh. Names of one or two letters
/// are near to all others of that kind, and count as no slips.
bool is_slip_of(std::string_view name, std::string_view meant);

}  // namespace silvafit::cli
