// SPDX-License-Identifier: MIT
// References to columns: a name, or an expression of columns.
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
  std::string text{};                      ///< as the user wrote it
  std::optional<Expression> expression{};  ///< none if `text` is the name of a column

  /// The columns that it reads.
  std::vector<std::string> columns() const;
};

/// The column that a variable of an expression reads: itself, or the one that it compares with
/// text.
std::string column_of(const std::string& variable);
/// Those of all variables of an expression, each once.
std::vector<std::string> columns_of(const Expression& expression);

/// pi is a number in expressions, also where a column has this name.
/// \throws FormulaError if a text has the word pi and one of the columns is called so
void refuse_column_pi(std::string_view text, std::span<const std::string> columns);

/// Interprets the right side of `--columns NAME=TEXT`, in the same way for all commands. A text
/// that equals the name of a column, including blanks, dots and brackets, is that column. Any other
/// text is an expression of columns, in which such names need backquotes.
/// \param name     the left side, for messages
/// \param columns  names of the table's columns
/// \param file     for messages
/// \throws FormulaError if the text is neither; InputError if a name in an expression is not a
///   column
ColumnReference column_reference(std::string_view name,
                                 std::string_view text,
                                 std::span<const std::string> columns,
                                 const std::string& file = {});

/// A cell with text in a column of numbers.
struct TextCell {
  std::size_t row = 0;
  std::string column{};
  std::string text{};
};

/// The numbers of a column that may also contain text. Missing values and text are NaN.
/// \param text_cells  the cells with text are added to it, in the order of the rows
/// \throws UsageError if there is no such column
std::vector<double> numbers_of(const Table& table,
                               std::string_view column,
                               std::vector<TextCell>& text_cells);

/// The same for a column or an expression of columns.
/// \throws UsageError also if an expression uses a column both as numbers and as text
std::vector<double> numbers_of(const Table& table,
                               const ColumnReference& reference,
                               std::vector<TextCell>& text_cells);

/// Adds a copy of a column of this or another table, or replaces the one with this name.
/// \throws UsageError if there is no such column, or its length differs from that of the table
void copy_column(std::string_view name, const Table& from, std::string_view source, Table& to);

}  // namespace silvafit::data
