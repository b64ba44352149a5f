// SPDX-License-Identifier: MIT
#include "gdal/workbook.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <optional>

#include "gdal/workbook_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"

namespace silvafit::source {
namespace {

constexpr char kSeparator = ';';

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// GDAL writes the dates of cells as 2023/04/05, followed by the time of day if there is one.
bool is_date(std::string_view cell) {
  constexpr std::string_view kPattern = "dddd/dd/dd";
  if (cell.size() < kPattern.size()) return false;
  for (std::size_t i = 0; i < kPattern.size(); ++i) {
    if (kPattern[i] == 'd' ? !is_digit(cell[i]) : cell[i] != '/') return false;
  }
  return cell.size() == kPattern.size() || cell[kPattern.size()] == ' ';
}

/// In the format of ISO 8601.
std::string iso_date(std::string_view cell) {
  std::string date(cell);
  date[4] = date[7] = '-';
  if (date.size() > 10) date[10] = 'T';
  return date;
}

/// A number as spreadsheets show it: with 15 digits, 0.3 instead of 0.30000000000000004.
std::optional<std::string> shown_number(std::string_view cell) {
  constexpr std::size_t kDigitsShown = 15;
  if (std::ranges::count_if(cell, is_digit) <= static_cast<std::ptrdiff_t>(kDigitsShown)) {
    return std::nullopt;
  }
  double value = 0.0;
  const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  // Long numbers without a point or exponent are names, such as those of records.
  const bool is_whole = cell.find_first_of(".eE") == std::string_view::npos;
  if (end != cell.data() + cell.size() || status != std::errc() || is_whole) return std::nullopt;
  return fmt::format("{:.15g}", value);
}

/// Writes the text of one sheet.
class SheetText {
 public:
  explicit SheetText(std::size_t columns) : numbers_(columns), dates_(columns) {}

  void add_row(const OGRFeature& feature, std::size_t row);
  std::string text() && { return std::move(text_); }
  std::optional<std::string> note_on_dates() const;

 private:
  void add_cell(std::string_view cell, std::size_t column, std::size_t row);
  void append_quoted(std::string_view cell);

  struct Dates {
    std::size_t count = 0;
    std::size_t first_row = 0;
  };
  std::string text_{};
  std::size_t line_ = 1;  // of the next row
  std::vector<std::size_t> numbers_;
  std::vector<Dates> dates_;
};

void SheetText::append_quoted(std::string_view cell) {
  if (cell.find_first_of(";\"\r\n") == std::string_view::npos) {
    text_ += cell;
    return;
  }
  text_ += '"';
  for (const char c : cell) {
    if (c == '"') text_ += '"';
    // A line end within a cell would shift the lines below it.
    if (c != '\r') text_ += c == '\n' ? ' ' : c;
  }
  text_ += '"';
}

void SheetText::add_cell(std::string_view cell, std::size_t column, std::size_t row) {
  double ignored = 0.0;
  if (is_date(cell)) {
    if (dates_[column].count++ == 0) dates_[column].first_row = row;
    return append_quoted(iso_date(cell));
  }
  if (data::parse_number(cell, ignored)) ++numbers_[column];
  const std::optional<std::string> number = shown_number(cell);
  append_quoted(number ? *number : cell);
}

void SheetText::add_row(const OGRFeature& feature, std::size_t row) {
  for (; line_ < row; ++line_) text_ += '\n';
  const auto columns = static_cast<int>(numbers_.size());
  int filled = 0;
  for (int i = 0; i < columns; ++i) {
    if (feature.IsFieldSetAndNotNull(i) != 0 && *feature.GetFieldAsString(i) != '\0') ++filled;
  }
  if (filled > 0) {
    // Comments are lines of one field.
    const bool is_comment = filled == 1 && *feature.GetFieldAsString(0) == '#';
    for (int i = 0; i < (is_comment ? 1 : columns); ++i) {
      if (i > 0) text_ += kSeparator;
      if (feature.IsFieldSetAndNotNull(i) != 0) {
        add_cell(feature.GetFieldAsString(i), static_cast<std::size_t>(i), row);
      }
    }
  }
  text_ += '\n';
  ++line_;
}

/// The letters of a column: A, B, ..., Z, AA.
std::string letters_of(std::size_t column) {
  std::string letters;
  for (std::size_t rest = column + 1; rest > 0; rest = (rest - 1) / 26) {
    letters.insert(letters.begin(), static_cast<char>('A' + (rest - 1) % 26));
  }
  return letters;
}

/// Numbers that a spreadsheet converted to dates, as some languages do with 12.3.
std::optional<std::string> SheetText::note_on_dates() const {
  for (std::size_t i = 0; i < dates_.size(); ++i) {
    if (dates_[i].count == 0 || numbers_[i] <= dates_[i].count) continue;
    return fmt::format(
        "in column {0}, {1} formatted as dates (first: {0}{2}) and cannot be read; "
        "enter them again as numbers",
        letters_of(i),
        counted(dates_[i].count, "number is", "numbers are"),
        dates_[i].first_row);
  }
  return std::nullopt;
}

}  // namespace

std::shared_ptr<const data::TableText> text_of_sheet(const Dataset& workbook,
                                                     OGRLayer& sheet,
                                                     std::vector<std::string>& notes) {
  const int columns = sheet.GetLayerDefn()->GetFieldCount();
  SheetText text(static_cast<std::size_t>(columns));
  for (const auto& feature : sheet) {
    text.add_row(*feature, static_cast<std::size_t>(feature->GetFID()));
  }
  workbook.require_sound();
  if (const auto note = text.note_on_dates()) notes.push_back(*note);
  const FormulasWithoutValue formulas =
      formulas_without_value(workbook.path(), workbook.layer_name());
  if (formulas.count > 0) {
    notes.push_back(fmt::format(
        "{} without a stored value (first: {}) and treated as missing; open the workbook in a "
        "spreadsheet program and save it",
        counted(formulas.count, "formula is", "formulas are"),
        formulas.first));
  }
  return std::make_shared<data::TableText>(data::TableText{
      .name = workbook.place(), .text = std::move(text).text(), .separator = kSeparator});
}

}  // namespace silvafit::source
