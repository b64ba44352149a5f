// SPDX-License-Identifier: MIT
// The cells of a sheet as delimited text, which is read like a CSV file.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/csv.hpp"

namespace silvafit::source {

/// The largest sheet of Excel and LibreOffice.
inline constexpr std::size_t kMostRows = 1048576;
inline constexpr std::size_t kMostColumns = 16384;

/// What the sheets of a workbook may still need; its size determines it, because a short text can
/// stand for many cells.
struct SheetBudget {
  std::size_t cells = 0;
  std::size_t bytes = 0;   ///< of their texts
  std::size_t fields = 0;  ///< of one sheet: rows with content times columns
};

/// The budget of a workbook, from the bytes of its unpacked parts.
SheetBudget sheet_budget(std::uint64_t unpacked_bytes);

/// The name of a cell, such as AB12.
/// \param row     from 1
/// \param column  from 0
std::string name_of_cell(std::size_t row, std::size_t column);

enum class CellKind {
  kText,
  kNumber,
  kLogical,         ///< 1 or 0
  kPercentage,      ///< a number; 0.25 where the sheet shows 25 %
  kDate,            ///< in the format of ISO 8601
  kError,           ///< the name of the error
  kMissingFormula,  ///< a formula without a stored value
};

/// Collects the cells of one sheet. Only cells with content need memory.
class SheetText {
 public:
  /// \param place   file and sheet, for messages
  /// \param budget  of the workbook, which the cells reduce; must outlive this object
  SheetText(std::string place, SheetBudget& budget) : place_(std::move(place)), budget_(&budget) {}

  /// Adds the next cell, row by row and from left to right. Numbers get the 15 digits that
  /// spreadsheets show.
  /// \param row     from 1
  /// \param column  from 0
  /// \throws InputError if the sheet needs more than its budget
  void add(std::size_t row, std::size_t column, std::string_view text, CellKind kind);
  /// The row of the last cell is hidden, by a filter or by hand.
  void note_hidden_row() { hidden_rows_.add(last_row_, 0); }

  /// Rows with content.
  std::size_t rows() const { return rows_; }

  /// One record a row, row n in line n. Logical values are 1 and 0, but TRUE and FALSE in a column
  /// of other numbers, such as diameters.
  /// \throws InputError if cells are far from the others, or a formula has no stored value
  std::shared_ptr<const data::TableText> text() const;
  /// What a user should know.
  std::vector<std::string> notes() const;

 private:
  struct Cell {
    std::uint32_t row = 0;
    std::uint32_t column = 0;
    std::size_t end = 0;  // of its text
  };
  /// Cells of a kind.
  struct Count {
    std::size_t count = 0;
    std::string first{};
    void add(std::size_t row, std::size_t column) {
      if (count++ == 0) first = name_of_cell(row, column);
    }
  };
  struct Column {
    std::size_t cells = 0;
    std::size_t numbers = 0;
    std::size_t measures = 0;  ///< numbers below its first cell that are no logical values
    Count percentages{};
    Count dates{};
  };

  std::string_view text_of(std::size_t cell) const;
  bool is_comment(std::size_t first) const;
  std::size_t used_columns() const;
  void require_near_cells() const;
  void require_values() const;
  std::string_view shown_text(std::size_t cell, bool is_logical) const;
  void count(std::size_t row, std::size_t column, std::string_view text, CellKind kind);

  std::string place_;
  SheetBudget* budget_;
  std::string texts_{};
  std::vector<Cell> cells_{};
  std::vector<std::size_t> logical_cells_{};  ///< positions in cells_
  std::vector<Column> columns_{};
  std::size_t rows_ = 0;
  std::size_t last_row_ = 0;
  Count hidden_rows_{};
  Count formulas_{};  ///< without a stored value
  std::size_t first_formula_row_ = 0;
  Count errors_{};
  std::string first_error_{};
};

}  // namespace silvafit::source
