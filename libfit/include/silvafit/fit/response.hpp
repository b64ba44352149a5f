// SPDX-License-Identifier: MIT
// Responses that are expressions of columns: log(h) ~ a + b*log(dbh).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::fit {

/// The left side of a formula, which may have bar terms: "h", or "log(h)".
/// \throws FormulaError if the formula cannot be read
std::string response_of(std::string_view formula);

/// The columns that a response reads: itself, or those of its expression.
std::vector<std::string> response_columns(const std::string& response);

/// Adds a response to a table under its text, if it is an expression and the table has its columns,
/// but not itself. Does nothing otherwise.
/// \throws InputError if a column has text, or if the expression has no value in a row with values
///   in its columns, such as the logarithm of a negative number
void add_response(const std::string& response, data::Table& table);

}  // namespace silvafit::fit
