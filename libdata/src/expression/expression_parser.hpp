// SPDX-License-Identifier: MIT
// From formula text to the expression graph.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "expression/expression_node.hpp"

namespace silvafit::data {

/// Whether a name that a factor or an exponent of zero removes is an error. In a model it would be
/// a parameter that nobody misses.
enum class UnusedNames { kAllowed, kRefused };

/// Parses the part [begin, end) of a text.
/// \throws FormulaError with the column in the whole text
NodePointer parse_part(std::string_view text,
                       std::size_t begin,
                       std::size_t end,
                       UnusedNames unused = UnusedNames::kAllowed);

/// The variable that stands for the comparison of a column with text.
std::string text_match_name(std::string_view column, std::string_view value);

/// True for bytes that a plain name may have inside; digits and `.` not at its start.
bool is_name_byte(char byte);

/// True for names that an expression contains without backquotes.
bool is_plain_name(std::string_view name);

}  // namespace silvafit::data
