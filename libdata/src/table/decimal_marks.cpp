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

/// \param reason  why the number may be read wrongly
[[noreturn]] void refuse_thousands(const MarkedNumber& number,
                                   char mark,
                                   const std::string& reason,
                                   Place place) {
  std::string without = number.text;
  std::erase(without, mark);
  throw InputError(
      fmt::format("'{}' can be {} or a number with three decimals, because {}; write numbers "
                  "without separators of thousands, and with one decimal mark in all columns",
                  number.text,
                  without,
                  reason),
      std::move(place));
}

/// A whole number above 0 without a mark.
void take_whole_number(std::string_view text, std::size_t line, DecimalMarks& marks) {
  constexpr std::size_t kDigitsBelowThousands = 3;
  if (!are_digits(text) || text.find_first_not_of('0') == std::string_view::npos) return;
  if (text.size() > kDigitsBelowThousands) marks.has_long_numbers = true;
  if (marks.whole.line == 0) marks.whole = {.text = std::string(text), .line = line};
}

}  // namespace

void DecimalMarks::add(std::string_view number, std::size_t line) {
  const std::string_view text = trimmed(number);
  const std::size_t mark = text.find_first_of(".,");
  if (mark == std::string_view::npos) return take_whole_number(text, line, *this);
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
    const char mark = has_points ? '.' : ',';
    const Place place{.file = file, .line = number.line, .column = header[column]};
    const MarkedNumber& whole = marks[column].whole;
    if (whole.line > 0 && !marks[column].has_long_numbers) {
      refuse_thousands(number,
                       mark,
                       fmt::format("the column has '{}' on line {}", whole.text, whole.line),
                       place);
    }
    for (const std::size_t other : columns) {
      const MarkedNumber& opposite = has_points ? marks[other].comma : marks[other].point;
      if (opposite.line == 0) continue;
      refuse_thousands(
          number,
          mark,
          fmt::format("{} has '{}' on line {}", header[other], opposite.text, opposite.line),
          place);
    }
  }
}

}  // namespace silvafit::data
