// SPDX-License-Identifier: MIT
// Expressions and conditions of a table's columns, as users write them: each name has to be a
// column, each value a number.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// Where a value is, for messages: file, line and column, with the plot and the tree of its row if
/// the table has columns of these names.
Place place_of(const Table& table, std::size_t row, std::string_view column);

/// Makes sure that columns which an expression reads as numbers hold numbers.
/// \param variables  of an expression, each a column; those that compare a column with text may
///                   have text
/// \throws InputError at the first value that is no number
void require_numeric(const Table& table, const std::vector<std::string>& variables);

/// (N) the values of an expression for the rows of a table.
/// \throws FormulaError if the text cannot be read; InputError that points at what is no column, or
///   if a column that the expression takes for numbers has text
std::vector<double> checked_values(std::string_view text, const Table& table);

/// The table's rows for which a condition holds, such as `species == "SM" && core == 1`. Where a
/// value of the condition is missing, it does not hold.
/// \throws as checked_values; InputError if the condition holds for no row
Table rows_where(std::string_view condition, const Table& table);

}  // namespace silvafit::data
