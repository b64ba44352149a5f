// SPDX-License-Identifier: MIT
// Suggestions for unknown names.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit {

/// The number of letters to insert, delete or replace, and of neighboring letters to swap, that
/// changes one text to the other (the optimal string alignment distance).
std::size_t slips_between(std::string_view one, std::string_view other);

/// The most similar of the names if it is similar enough for a suggestion; else empty.
std::string nearest_name(std::string_view name, const std::vector<std::string>& names);

/// "; did you mean X?" for the most similar of the names; else "; available: X, Y".
std::string did_you_mean(std::string_view name, const std::vector<std::string>& names);

/// Whether two names differ by one typing error, such as dhb and dbh, or by case and punctuation
/// only, such as DBH and d.b.h. Names of one or two letters are always similar by the first rule,
/// so it does not apply to them; the second applies from two letters on.
bool is_slip_of(std::string_view name, std::string_view meant);

/// Whether the shorter of two names abbreviates the longer: it has at least two letters, begins
/// with the same one, and the longer has all its letters in their order, as ht in height and diam
/// in diameter_cm. Case and punctuation do not count.
bool is_abbreviation(std::string_view one, std::string_view other);

/// The names that may be meant by an unknown one: those of is_slip_of; if there is none, those of
/// is_abbreviation; if there is none, nearest_name for names of three letters or more.
std::vector<std::string> names_near(std::string_view name, std::span<const std::string> names);

}  // namespace silvafit
