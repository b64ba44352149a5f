// SPDX-License-Identifier: MIT
#include "workbook/sheet_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"

namespace silvafit::source {
namespace {

constexpr char kSeparator = ';';

/// A number as spreadsheets show it: with 15 digits, 0.3 instead of 0.30000000000000004, and 1
/// instead of 1.0, because it may be a label.
std::optional<std::string> shown_number(std::string_view cell) {
  constexpr std::ptrdiff_t kDigitsShown = 15;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  // Long numbers without a point or exponent are names, such as those of records.
  if (cell.find_first_of(".eE") == std::string_view::npos) return std::nullopt;
  const bool is_short = std::ranges::count_if(cell, is_digit) <= kDigitsShown;
  if (is_short && !cell.ends_with('0') && cell.find_first_of("eE") == std::string_view::npos) {
    return std::nullopt;
  }
  double value = 0.0;
  if (!data::parse_number(cell, value)) return std::nullopt;
  return fmt::format("{:.15g}", value);
}

/// The letters of a column: A, B, ..., Z, AA.
std::string letters_of(std::size_t column) {
  std::string letters;
  for (std::size_t rest = column + 1; rest > 0; rest = (rest - 1) / 26) {
    letters.insert(letters.begin(), static_cast<char>('A' + (rest - 1) % 26));
  }
  return letters;
}

void append_quoted(std::string& text, std::string_view cell) {
  if (cell.find_first_of(";\"\r\n") == std::string_view::npos) {
    text += cell;
    return;
  }
  text += '"';
  for (const char c : cell) {
    if (c == '"') text += '"';
    // A line end within a cell would shift the lines below it.
    if (c != '\r') text += c == '\n' ? ' ' : c;
  }
  text += '"';
}

}  // namespace

SheetBudget sheet_budget(std::uint64_t unpacked_bytes) {
  constexpr std::size_t kFreeCells = 1000000;
  constexpr std::size_t kFreeBytes = std::size_t{64} << 20U;
  constexpr std::size_t kFreeFields = 20000000;
  // A cell of its own has more than 10 bytes of XML; names that recur, some four times their bytes.
  constexpr std::size_t kRecurring = 4;
  const auto bytes = static_cast<std::size_t>(unpacked_bytes);
  return {.cells = kFreeCells + bytes,
          .bytes = kFreeBytes + kRecurring * bytes,
          .fields = std::max(kFreeFields, bytes)};
}

std::string name_of_cell(std::size_t row, std::size_t column) {
  return letters_of(column) + std::to_string(row);
}

void SheetText::add(std::size_t row, std::size_t column, std::string_view text, CellKind kind) {
  // A code of missing values in every column, and no empty cell, which may be a merged one.
  const std::string_view kept = kind == CellKind::kError ? "NA" : text;
  if (budget_->cells == 0 || budget_->bytes < kept.size()) {
    throw InputError(
        fmt::format("at the cell {} the sheet has more content than a workbook of its size should; "
                    "does it repeat cells or long texts? Save the table alone, or as CSV in UTF-8",
                    name_of_cell(row, column)),
        {.file = place_, .line = row});
  }
  --budget_->cells;
  budget_->bytes -= kept.size();
  count(row, column, text, kind);
  if (kept.empty()) return;
  if (row != last_row_) ++rows_;
  last_row_ = row;
  const bool is_number = kind == CellKind::kNumber || kind == CellKind::kPercentage;
  texts_ += is_number ? shown_number(kept).value_or(std::string(kept)) : std::string(kept);
  cells_.push_back({.row = static_cast<std::uint32_t>(row),
                    .column = static_cast<std::uint32_t>(column),
                    .end = texts_.size()});
  if (kind == CellKind::kLogical) logical_cells_.push_back(cells_.size() - 1);
  ++columns_[column].cells;
}

void SheetText::count(std::size_t row, std::size_t column, std::string_view text, CellKind kind) {
  if (column >= columns_.size()) columns_.resize(column + 1);
  Column& own = columns_[column];
  double ignored = 0.0;
  switch (kind) {
    case CellKind::kDate:
      return own.dates.add(row, column);
    case CellKind::kMissingFormula:
      if (formulas_.count == 0) first_formula_row_ = row;
      return formulas_.add(row, column);
    case CellKind::kLogical:
      return;
    case CellKind::kError:
      // Spreadsheets have this one for values that are not available.
      if (text == "#N/A") return;
      if (errors_.count == 0) first_error_ = text;
      return errors_.add(row, column);
    case CellKind::kPercentage:
      own.percentages.add(row, column);
      break;
    case CellKind::kText:
      if (!data::parse_number(text, ignored)) return;
      break;
    case CellKind::kNumber:
      break;
  }
  ++own.numbers;
  if (own.cells > 0 && text != "0" && text != "1") ++own.measures;
}

std::string_view SheetText::text_of(std::size_t cell) const {
  const std::size_t begin = cell == 0 ? 0 : cells_[cell - 1].end;
  return std::string_view(texts_).substr(begin, cells_[cell].end - begin);
}

/// TRUE in a column of diameters is not 1 cm.
std::string_view SheetText::shown_text(std::size_t cell, bool is_logical) const {
  const std::string_view text = text_of(cell);
  if (!is_logical || columns_[cells_[cell].column].measures == 0) return text;
  return text == "1" ? "TRUE" : "FALSE";
}

/// Up to the last one with content.
std::size_t SheetText::used_columns() const {
  std::size_t used = columns_.size();
  while (used > 0 && columns_[used - 1].cells == 0) --used;
  return used;
}

/// Comments are lines of one field.
bool SheetText::is_comment(std::size_t first) const {
  const bool is_alone = first + 1 == cells_.size() || cells_[first + 1].row != cells_[first].row;
  return is_alone && cells_[first].column == 0 && text_of(first).starts_with('#');
}

void SheetText::require_near_cells() const {
  constexpr std::size_t kMostEmptyRows = 10000;
  constexpr std::size_t kMostEmptyColumns = 1000;
  const auto refuse = [&](std::size_t row, std::size_t column) {
    throw InputError(
        fmt::format("the cell {} is far from the others; delete the cells that are far from the "
                    "table, and save the workbook again",
                    name_of_cell(row, column)),
        {.file = place_, .line = row});
  };
  for (std::size_t i = 1; i < cells_.size(); ++i) {
    if (cells_[i].row - cells_[i - 1].row > kMostEmptyRows) refuse(cells_[i].row, cells_[i].column);
  }
  std::size_t last = 0;
  const std::size_t columns = used_columns();
  for (std::size_t column = 0; column < columns; ++column) {
    if (columns_[column].cells == 0) continue;
    if (column - last > kMostEmptyColumns) {
      refuse(std::ranges::find(cells_, column, &Cell::column)->row, column);
    }
    last = column;
  }
  if (rows_ <= budget_->fields / std::max<std::size_t>(columns, 1)) return;
  throw InputError(
      fmt::format("a sheet has {} rows and {} columns, nearly all of them without content; delete "
                  "the cells that are far from the table, and save the workbook again",
                  rows_,
                  columns),
      {.file = place_});
}

/// Programs that do not compute, such as Python's openpyxl, write formulas alone. Without their
/// values, columns such as a status would be empty, which means alive.
void SheetText::require_values() const {
  if (formulas_.count == 0) return;
  throw InputError(
      fmt::format("{} without a stored value (first: {}); open the workbook in Excel or "
                  "LibreOffice, which compute it, and save it there",
                  counted(formulas_.count, "cell has a formula", "cells have formulas"),
                  formulas_.first),
      {.file = place_, .line = first_formula_row_});
}

std::shared_ptr<const data::TableText> SheetText::text() const {
  require_values();
  require_near_cells();
  std::string text;
  const std::size_t columns = used_columns();
  text.reserve(texts_.size() + rows_ * columns);
  std::size_t line = 1;
  auto logical = logical_cells_.begin();
  const auto next_text = [&](std::size_t cell) {
    const bool is_logical = logical != logical_cells_.end() && *logical == cell;
    if (is_logical) ++logical;
    return shown_text(cell, is_logical);
  };
  for (std::size_t i = 0; i < cells_.size();) {
    const std::size_t row = cells_[i].row;
    text.append(row - line, '\n');
    const std::size_t fields = is_comment(i) ? 1 : columns;
    for (std::size_t column = 0; column < fields; ++column) {
      if (column > 0) text += kSeparator;
      if (i == cells_.size() || cells_[i].row != row || cells_[i].column != column) continue;
      append_quoted(text, next_text(i++));
    }
    text += '\n';
    line = row + 1;
  }
  return std::make_shared<data::TableText>(
      data::TableText{.name = place_, .text = std::move(text), .separator = kSeparator});
}

std::vector<std::string> SheetText::notes() const {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const Column& column = columns_[i];
    const std::string name = letters_of(i);
    // Spreadsheets in some languages convert 12.3 to a date.
    if (column.dates.count > 0 && column.numbers > column.dates.count) {
      notes.push_back(fmt::format(
          "in column {}, {} formatted as dates (first: {}) and cannot be read; enter them again as "
          "numbers",
          name,
          counted(column.dates.count, "number is", "numbers are"),
          column.dates.first));
    }
    if (column.percentages.count > 0) {
      notes.push_back(
          fmt::format("in column {}, {} formatted as percentages (first: {}) and read as "
                      "fractions: 25 % as 0.25",
                      name,
                      counted(column.percentages.count, "number is", "numbers are"),
                      column.percentages.first));
    }
  }
  if (errors_.count > 0) {
    notes.push_back(
        fmt::format("{} treated as missing (first: {} in {})",
                    counted(errors_.count, "cell with an error is", "cells with errors are"),
                    first_error_,
                    errors_.first));
  }
  if (hidden_rows_.count > 0) {
    notes.push_back(fmt::format("{} (first: {}) and read like the others",
                                counted(hidden_rows_.count, "row is hidden", "rows are hidden"),
                                hidden_rows_.first.substr(1)));
  }
  return notes;
}

}  // namespace silvafit::source
