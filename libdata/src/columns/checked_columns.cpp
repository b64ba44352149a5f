// SPDX-License-Identifier: MIT
#include "silvafit/data/checked_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "silvafit/base/words.hpp"
#include "silvafit/data/column_reference.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/name_list.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::data {
namespace {

/// "", or " (and 3 more)".
std::string others(std::size_t count) {
  return count > 1 ? fmt::format(" (and {} more)", count - 1) : "";
}

/// Throws at the first name that is not a column, with its position in the text.
void require_columns(const Expression& expression, std::string_view text, const Table& table) {
  for (const std::string& column : columns_of(expression)) {
    if (table.has(column)) continue;
    const FormulaError shown(
        fmt::format("unknown column '{}' (put text in double quotes); available: {}",
                    column,
                    list_of(table.names())),
        text,
        text.find(column) + 1);
    // An error of the file, not of the command: with another file the command can be correct.
    throw InputError(shown.what(), {.file = table.file()});
  }
}

bool is_number(std::string_view text) {
  double ignored = 0.0;
  return parse_number(text, ignored);
}

}  // namespace

Place place_of(const Table& table, std::size_t row, std::string_view column) {
  Place place{.file = table.file(), .column = std::string(column)};
  if (table.line(row) > 0) place.line = table.line(row);
  if (table.has("plot")) place.plot = table.labels("plot")[row];
  if (table.has("tree")) place.tree = table.labels("tree")[row];
  return place;
}

void require_numeric(const Table& table, const std::vector<std::string>& variables) {
  for (const std::string& name : variables) {
    TextMatch match;
    if (is_text_match(name, match)) continue;
    if (table.is_numeric(name)) continue;
    const TextColumn& column = table.text(name);
    std::vector<std::size_t> rows;
    std::vector<std::size_t> with_comma;
    for (std::size_t row = 0; row < column.size(); ++row) {
      if (column.is_missing(row) || is_number(column[row])) continue;
      // In a file with decimal commas 12,5 is a number, and another field is the problem.
      const bool has_comma = !with_decimal_point(column[row]).empty();
      (has_comma ? with_comma : rows).push_back(row);
    }
    if (rows.empty()) rows = with_comma;
    if (rows.empty()) {
      const auto known = std::ranges::find_if(column.levels(), is_number);
      throw InputError(
          known == column.levels().end()
              ? std::string("has no numbers")
              : fmt::format("holds texts such as '{}'; make them numbers (labels, and columns with "
                            "a text in a row that is skipped, are texts)",
                            *known),
          {.file = table.file(), .column = name});
    }
    throw InputError(
        fmt::format("'{}' is not a number{}", column[rows.front()], others(rows.size())),
        place_of(table, rows.front(), name));
  }
}

std::vector<double> checked_values(std::string_view text, const Table& table) {
  refuse_column_pi(text, table.names());
  const Expression expression = Expression::parse(text);
  require_columns(expression, text, table);
  require_numeric(table, expression.variables());
  return evaluate(expression, table);
}

std::vector<std::size_t> rows_that_satisfy(std::string_view condition, const Table& table) {
  const std::vector<double> holds = checked_values(condition, table);
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < holds.size(); ++row) {
    if (std::isnan(holds[row]) || holds[row] == 0.0) continue;
    if (holds[row] != 1.0) {
      throw UsageError(fmt::format("{} is {} here, and no condition, which is true or false; "
                                   "compare it, as in {} > 0",
                                   condition,
                                   shortest(holds[row]),
                                   condition),
                       place_of(table, row, "`where`"));
    }
    rows.push_back(row);
  }
  return rows;
}

std::string describe_compared_texts(std::string_view condition, const Table& table) {
  std::string text;
  const auto add = [&text](std::string part) { text += (text.empty() ? "" : "; ") + part; };
  for (const std::string& variable : Expression::parse(condition).variables()) {
    TextMatch match;
    if (!is_text_match(variable, match) || !table.has(match.column)) continue;
    const TextColumn labels = table.labels(match.column);
    std::vector<std::string> similar;
    bool occurs = false;
    for (const std::string& level : labels.levels()) {
      occurs = occurs || level == match.value;
      const bool is_alike = are_equal_words(trimmed(level), trimmed(match.value));
      if (level != match.value && is_alike) similar.push_back(level);
    }
    if (!similar.empty()) {
      add(fmt::format("{} has {} beside {}, which the condition does not mean",
                      match.column,
                      list_of(similar),
                      match.value));
    } else if (!occurs) {
      add(fmt::format("no row has the {} {}", match.column, match.value));
    }
  }
  return text;
}

Table rows_where(std::string_view condition, const Table& table) {
  const std::vector<std::size_t> rows = rows_that_satisfy(condition, table);
  if (rows.empty()) {
    throw InputError(fmt::format("no row satisfies the condition {}", condition),
                     {.file = table.file()});
  }
  return table.select(rows);
}

}  // namespace silvafit::data
