// SPDX-License-Identifier: MIT
// Apostrophes before what a spreadsheet may read as a formula.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace silvafit::data {

/// A text with an apostrophe before each part that a spreadsheet may read as a formula. Parts are
/// separated by semicolons and tabs, which may separate cells, and by ends of lines, even in a
/// quoted field that is not the first of its line.
std::string with_guards(std::string_view text);

/// A field of which a reader makes the text again: one apostrophe more before each part from which
/// the reader would remove one.
std::string with_kept_apostrophes(std::string_view text);

/// Removes the apostrophes that with_guards has added, in place; returns the new length.
std::size_t remove_guards(char* text, std::size_t length);

}  // namespace silvafit::data
