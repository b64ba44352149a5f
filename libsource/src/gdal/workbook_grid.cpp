// SPDX-License-Identifier: MIT
#include "gdal/workbook_grid.hpp"

#include <algorithm>
#include <charconv>

namespace silvafit::source {
namespace {

/// GDAL ignores rows that are repeated more often, and all behind them.
constexpr std::size_t kMostRepeats = 10000;

/// The local name of a tag, such as `c` of `<x:c r="A1">`.
std::string_view name_of_tag(std::string_view tag) {
  std::string_view name = tag.substr(1, tag.find_first_of(" \t\r\n/>", 1) - 1);
  return name.substr(name.find(':') + 1);
}

constexpr std::string_view kBlanks = " \t\r\n";

/// The value of an attribute, by its local name; empty if there is none.
std::string_view attribute(std::string_view tag, std::string_view name) {
  std::string_view rest = tag.substr(std::min(tag.find_first_of(kBlanks), tag.size()));
  for (;;) {
    rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
    const std::size_t equals = rest.find('=');
    const std::size_t open = rest.find_first_of("\"'");
    if (equals == std::string_view::npos || open == std::string_view::npos) return {};
    const std::string_view own = rest.substr(0, rest.find_first_of(" \t\r\n="));
    const std::size_t close = std::min(rest.find(rest[open], open + 1), rest.size() - 1);
    if (own.substr(own.find(':') + 1) == name) return rest.substr(open + 1, close - open - 1);
    rest.remove_prefix(close + 1);
  }
}

std::size_t number_or(std::string_view text, std::size_t otherwise) {
  constexpr std::size_t kMost = 1000000000000;  // so that sums of them cannot overflow
  std::size_t value = otherwise;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return std::min(value, kMost);
}

/// The column of a cell such as AB12, from 1; 0 if the text is not the name of a cell.
std::size_t column_of(std::string_view cell) {
  std::size_t column = 0;
  for (std::size_t i = 0; i < cell.size() && i < 8; ++i) {
    if (cell[i] < 'A' || cell[i] > 'Z') break;
    column = 26 * column + static_cast<std::size_t>(cell[i] - 'A' + 1);
  }
  return column;
}

/// The end of the tag that begins a text: behind its >, which may also occur in quotes; 0 if the
/// text ends before.
std::size_t end_of_tag(std::string_view text) {
  char quote = '\0';
  for (std::size_t i = 1; i < text.size(); ++i) {
    const char c = text[i];
    if (quote != '\0') {
      if (c == quote) quote = '\0';
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return i + 1;
    }
  }
  return 0;
}

/// Elements of a cell that have a value: <v>, <is> of Excel; <p> of OpenDocument.
bool is_content(std::string_view name) { return name == "v" || name == "is" || name == "p"; }

}  // namespace

void GridScan::add(std::string_view block) {
  constexpr std::size_t kLongestTag = std::size_t{1} << 20;
  if (bytes_ == 0) {
    const std::string_view start = block.substr(0, 4);
    is_unusual_ = !(start.starts_with('<') || start.starts_with("\xEF\xBB\xBF")) ||
                  start.find('\0') != std::string_view::npos;
  }
  bytes_ += block.size();
  rest_ += block;
  std::string_view text = rest_;
  for (;;) {
    const std::size_t begin = text.find('<');
    text.remove_prefix(std::min(begin, text.size()));
    if (text.empty()) break;
    const bool is_declaration = text.starts_with("<!") && !text.starts_with("<!--");
    // The quotes of a comment do not count.
    const std::size_t end = text.starts_with("<!--") ? text.find("-->") + 1 : end_of_tag(text);
    if (end == 0) break;
    is_unusual_ = is_unusual_ || (is_declaration && !text.starts_with("<![CDATA["));
    take_tag(text.substr(0, end));
    text.remove_prefix(end);
  }
  is_unusual_ = is_unusual_ || text.size() > kLongestTag;
  rest_ = text;
}

void GridScan::take_tag(std::string_view tag) {
  const std::string_view name = name_of_tag(tag);
  if (name == "table") {
    row_ = last_column_ = 0;
    is_behind_gap_ = false;
  } else if (name == "row" || name == "table-row") {
    begin_row(tag);
  } else if (name == "c" || name == "table-cell" || name == "covered-table-cell") {
    begin_cell(tag);
  } else if (is_content(name)) {
    note_content();
  }
}

void GridScan::begin_row(std::string_view tag) {
  row_repeats_ = number_or(attribute(tag, "number-rows-repeated"), 1);
  row_ = std::max(row_ + row_repeats_, number_or(attribute(tag, "r"), 0));
  column_ = 0;
  is_behind_gap_ = is_behind_gap_ || row_repeats_ > kMostRepeats;
}

void GridScan::begin_cell(std::string_view tag) {
  column_ += number_or(attribute(tag, "number-columns-repeated"), 1);
  column_ = std::max(column_, column_of(attribute(tag, "r")));
  if (!attribute(tag, "value-type").empty()) note_content();
}

void GridScan::note_content() {
  has_cells_behind_gap_ = has_cells_behind_gap_ || is_behind_gap_;
  last_column_ = std::max(last_column_, column_);
  const double grid = static_cast<double>(row_) * static_cast<double>(last_column_);
  if (grid <= largest_grid_) return;
  largest_grid_ = grid;
  rows_of_largest_ = row_;
  columns_of_largest_ = last_column_;
}

}  // namespace silvafit::source
