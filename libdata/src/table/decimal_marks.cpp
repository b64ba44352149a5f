// SPDX-License-Identifier: MIT
#include "silvafit/data/decimal_marks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::data {
namespace {

bool are_digits(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

/// Whether a number is one to three digits, the mark, and three digits.
bool has_form_of_thousands(std::string_view number, std::size_t mark) {
  std::string_view before = number.substr(0, mark);
  if (before.starts_with('-') || before.starts_with('+')) before.remove_prefix(1);
  const std::string_view after = number.substr(mark + 1);
  return !before.empty() && before.size() <= 3 && before.front() != '0' && after.size() == 3 &&
         are_digits(before) && are_digits(after);
}

/// \param other  a number of another column, whose mark is the other one
[[noreturn]] void refuse_thousands(const MarkedNumber& number,
                                   char mark,
                                   const MarkedNumber& other,
                                   const std::string& other_column,
                                   Place place) {
  std::string without = number.text;
  std::erase(without, mark);
  throw InputError(
      fmt::format("'{}' can be {} or a number with three decimals, because {} has '{}' on line {}; "
                  "write numbers without separators of thousands, and with one decimal mark in all "
                  "columns",
                  number.text,
                  without,
                  other_column,
                  other.text,
                  other.line),
      std::move(place));
}

}  // namespace

void DecimalMarks::add(std::string_view number, std::size_t line) {
  const std::string_view text = trimmed(number);
  const std::size_t mark = text.find_first_of(".,");
  if (mark == std::string_view::npos) return;
  MarkedNumber& known = text[mark] == '.' ? point : comma;
  if (known.line == 0) {
    known.text = text;
    known.line = line;
  }
  if (known.may_be_thousands && !has_form_of_thousands(text, mark)) known.may_be_thousands = false;
}

void require_one_mark(const DecimalMarks& marks,
                      const std::string& file,
                      const std::string& column) {
  if (!marks.are_mixed()) return;
  const bool point_is_first = marks.point.line < marks.comma.line;
  const MarkedNumber& first = point_is_first ? marks.point : marks.comma;
  const MarkedNumber& second = point_is_first ? marks.comma : marks.point;
  throw InputError(
      fmt::format("'{}' has a {} and '{}' on line {} a {}; write all numbers of the column with "
                  "one decimal mark, and without separators of thousands",
                  second.text,
                  point_is_first ? "comma" : "point",
                  first.text,
                  first.line,
                  point_is_first ? "point" : "comma"),
      {.file = file, .line = second.line, .column = column});
}

void require_clear_marks(const std::vector<DecimalMarks>& marks,
                         std::span<const std::size_t> columns,
                         const std::string& file,
                         const std::vector<std::string>& header) {
  for (const std::size_t column : columns) require_one_mark(marks[column], file, header[column]);
  for (const std::size_t column : columns) {
    const bool has_points = marks[column].point.line > 0;
    const MarkedNumber& number = has_points ? marks[column].point : marks[column].comma;
    if (number.line == 0 || !number.may_be_thousands) continue;
    for (const std::size_t other : columns) {
      const MarkedNumber& opposite = has_points ? marks[other].comma : marks[other].point;
      if (opposite.line == 0) continue;
      refuse_thousands(number,
                       has_points ? '.' : ',',
                       opposite,
                       header[other],
                       {.file = file, .line = number.line, .column = header[column]});
    }
  }
}

}  // namespace silvafit::data
