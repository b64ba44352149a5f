// SPDX-License-Identifier: MIT
#include "silvafit/data/column_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <regex>
#include <utility>

#include "expression/expression_parser.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::data {
namespace {

bool is_among(std::string_view name, std::span<const std::string> columns) {
  return std::ranges::find(columns, name) != columns.end();
}

/// The longest column name in the text that an expression can only contain in backquotes; empty if
/// there is none.
std::string column_to_quote(std::string_view text, std::span<const std::string> columns) {
  std::string longest;
  for (const std::string& name : columns) {
    if (name.size() <= longest.size() || text.find(name) == std::string_view::npos) continue;
    if (!is_plain_name(name)) longest = name;
  }
  return longest;
}

/// The parser's message without the place and the text that a FormulaError adds.
std::string reason_of(const FormulaError& error) {
  const std::string line = error.message().substr(0, error.message().find('\n'));
  return line.substr(line.find(": ") + 2);
}

/// Parses an expression. The error covers two causes: a column name without backquotes, and an
/// unknown column.
Expression expression_of(std::string_view text, std::span<const std::string> columns) {
  try {
    return Expression::parse(text);
  } catch (const FormulaError& error) {
    const std::string name = column_to_quote(text, columns);
    const std::string remedy =
        name.empty() ? fmt::format("unknown column '{}'; available: {}", text, list_of(columns))
                     : fmt::format("in an expression write `{}`, in backquotes", name);
    throw FormulaError(fmt::format("{}; {}", reason_of(error), remedy), text, error.position());
  }
}

std::vector<double> numbers_of_expression(const Table& table,
                                          const Expression& expression,
                                          std::vector<TextCell>& text_cells) {
  // A separate table, in which columns with some text are numeric.
  Table own(table.rows());
  std::vector<TextCell> cells;
  const std::vector<std::string> variables = expression.variables();
  for (const std::string& variable : variables) {
    const std::string column = column_of(variable);
    if (column != variable) {
      if (!own.has(column)) own.set(column, table.labels(column));
      continue;
    }
    const bool is_also_text = std::ranges::any_of(variables, [&](const std::string& other) {
      return other != variable && column_of(other) == column;
    });
    if (is_also_text && !table.is_numeric(column)) {
      throw UsageError(fmt::format("'{}' is used as a number and as text", column),
                       {.file = table.file(), .column = "`columns`"});
    }
    own.set(column, numbers_of(table, column, cells));
  }
  std::ranges::stable_sort(cells, {}, &TextCell::row);
  std::ranges::move(cells, std::back_inserter(text_cells));
  return evaluate(expression, own);
}

}  // namespace

std::string column_of(const std::string& variable) {
  TextMatch match;
  return is_text_match(variable, match) ? match.column : variable;
}

std::vector<std::string> columns_of(const Expression& expression) {
  std::vector<std::string> columns;
  for (const std::string& variable : expression.variables()) {
    std::string column = column_of(variable);
    if (!is_among(column, columns)) columns.push_back(std::move(column));
  }
  return columns;
}

std::vector<std::string> ColumnReference::columns() const {
  return expression ? columns_of(*expression) : std::vector<std::string>{text};
}

void refuse_column_pi(std::string_view text, std::span<const std::string> columns) {
  static const std::regex word("(?:^|[^\\w.`\"'])(pi)(?![\\w.`\"'])");
  std::match_results<std::string_view::const_iterator> found;
  if (!is_among("pi", columns) || !std::regex_search(text.begin(), text.end(), found, word)) return;
  throw FormulaError(
      "pi is 3.14159... here, but a column has this name; write the column in backquotes, or "
      "rename it",
      text,
      static_cast<std::size_t>(found.position(1)) + 1);
}

ColumnReference column_reference(std::string_view name,
                                 std::string_view text,
                                 std::span<const std::string> columns,
                                 const std::string& file) {
  if (is_among(text, columns)) return {.text = std::string(text)};
  refuse_column_pi(text, columns);
  Expression expression = expression_of(text, columns);
  for (const std::string& column : columns_of(expression)) {
    if (is_among(column, columns)) continue;
    throw InputError(
        fmt::format(
            "unknown column '{}' in {}={}; available: {}", column, name, text, list_of(columns)),
        {.file = file});
  }
  return {.text = std::string(text), .expression = std::move(expression)};
}

std::vector<double> numbers_of(const Table& table,
                               std::string_view column,
                               std::vector<TextCell>& text_cells) {
  if (table.is_numeric(column)) {
    const std::span<const double> numbers = table.numbers(column);
    return {numbers.begin(), numbers.end()};
  }
  const TextColumn& texts = table.text(column);
  std::vector<double> numbers(texts.size(), kMissing);
  for (std::size_t row = 0; row < texts.size(); ++row) {
    if (texts.is_missing(row) || parse_number(texts[row], numbers[row])) continue;
    numbers[row] = kMissing;
    if (is_missing_number(texts[row])) continue;
    text_cells.push_back({row, std::string(column), std::string(texts[row])});
  }
  return numbers;
}

std::vector<double> numbers_of(const Table& table,
                               const ColumnReference& reference,
                               std::vector<TextCell>& text_cells) {
  if (!reference.expression) return numbers_of(table, reference.text, text_cells);
  return numbers_of_expression(table, *reference.expression, text_cells);
}

void copy_column(std::string_view name, const Table& from, std::string_view source, Table& to) {
  if (!from.is_numeric(source)) return to.set(name, TextColumn(from.text(source)));
  const std::span<const double> values = from.numbers(source);
  to.set(name, std::vector<double>(values.begin(), values.end()));
}

}  // namespace silvafit::data
