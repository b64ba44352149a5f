// SPDX-License-Identifier: MIT
// From formula text to the expression graph.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "expression/expression_node.hpp"
#include "silvafit/data/expression_parts.hpp"

namespace silvafit::data {

/// Parses the part [begin, end) of a text.
/// \param names  set to the names in the part, also those that vanish from the value
/// \throws FormulaError with the column in the whole text
NodePointer parse_part(std::string_view text,
                       std::size_t begin,
                       std::size_t end,
                       std::vector<NamePlace>* names = nullptr);

/// The variable that stands for the comparison of a column with text.
std::string text_match_name(std::string_view column, std::string_view value);

/// True for bytes that a plain name may have inside; digits and `.` not at its start.
bool is_name_byte(char byte);

/// True for names that an expression contains without backquotes.
bool is_plain_name(std::string_view name);

}  // namespace silvafit::data
