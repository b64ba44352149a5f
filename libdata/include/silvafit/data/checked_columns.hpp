// SPDX-License-Identifier: MIT
// Expressions and conditions that users write in the columns of a table. Every name must be a
// column, and every value a number.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// The place of a value for messages: file, line and column, and the plot and tree of its row if
/// the table has columns with these names.
Place place_of(const Table& table, std::size_t row, std::string_view column);

/// Checks that the columns that an expression reads as numbers contain numbers only.
/// \param variables  of an expression. Columns that it compares with text may contain text.
/// \throws InputError at the first value that is not a number
void require_numeric(const Table& table, const std::vector<std::string>& variables);

/// (N) the values of an expression for the rows of a table.
/// \throws FormulaError if the text cannot be parsed; InputError if a name is not a column, with
///   its place in the text, or if a numeric column contains text
std::vector<double> checked_values(std::string_view text, const Table& table);

/// The rows for which a condition is true, such as `species == "SM" && core == 1`, of which there
/// may be none. A condition with a missing value is false.
/// \throws as checked_values; UsageError if its values are others than true and false, 1 and 0
std::vector<std::size_t> rows_that_satisfy(std::string_view condition, const Table& table);

/// What is odd about the texts that a condition compares with columns: they do not occur, or with
/// other capitals or blanks, too. Empty: nothing.
std::string describe_compared_texts(std::string_view condition, const Table& table);

/// The table of these rows.
/// \throws as rows_that_satisfy; InputError if there are none
Table rows_where(std::string_view condition, const Table& table);

}  // namespace silvafit::data
