// SPDX-License-Identifier: MIT
// What stands for a column: its name as it is, or an expression of columns.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/expression.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// A column of a table, or an expression of its columns.
struct ColumnReference {
  std::string text{};                      ///< as it was written
  std::optional<Expression> expression{};  ///< none: `text` is a column's name
};

/// The right side of `--columns NAME=TEXT`, by the one rule that all commands have: a text that
/// equals the name of a column, with its blanks, dots and brackets, is that column; any other is an
/// expression of columns, in which such names stand in backquotes.
/// \param name     what the column is to be, for messages
/// \param columns  of the table
/// \param file     for messages
/// \throws FormulaError if the text is neither; InputError if an expression names what is no column
ColumnReference column_reference(std::string_view name,
                                 std::string_view text,
                                 std::span<const std::string> columns,
                                 const std::string& file = {});

/// A cell that holds text where a number belongs.
struct TextCell {
  std::size_t row = 0;
  std::string column{};
  std::string text{};
};

/// The numbers of a column, whether or not all of its cells are numbers. A missing cell is NaN.
/// \param text_cells  gets the cells that hold text, in the order of the rows; they are NaN, too
/// \throws UsageError if there is no such column
std::vector<double> numbers_of(const Table& table,
                               std::string_view column,
                               std::vector<TextCell>& text_cells);

/// The same of a column or an expression of columns.
/// \throws UsageError also if an expression reads a column of text as a number and as text
std::vector<double> numbers_of(const Table& table,
                               const ColumnReference& reference,
                               std::vector<TextCell>& text_cells);

}  // namespace silvafit::data
