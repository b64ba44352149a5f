// SPDX-License-Identifier: MIT
// The size of the sheets of a workbook, from the text of its XML.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace silvafit::source {

/// Scans the XML of one sheet of Excel, or of all sheets of an OpenDocument workbook, block by
/// block. It sees all elements that a parser would: entities, with which a short text can stand for
/// a long one, are refused.
class GridScan {
 public:
  /// Takes the next bytes.
  void add(std::string_view block);

  /// Rows times columns from the first cell to the last one with content, of the largest sheet.
  double largest_grid() const { return largest_grid_; }
  std::size_t rows() const { return rows_of_largest_; }
  std::size_t columns() const { return columns_of_largest_; }
  std::size_t bytes() const { return bytes_; }
  /// Whether a cell with content is in or behind rows that are repeated more often than GDAL
  /// accepts. LibreOffice writes such rows, without content, to the end of a sheet.
  bool has_cells_behind_gap() const { return has_cells_behind_gap_; }
  /// Whether the text is not plain XML in UTF-8 without entities.
  bool is_unusual() const { return is_unusual_; }

 private:
  void take_tag(std::string_view tag);
  void begin_row(std::string_view tag);
  void begin_cell(std::string_view tag);
  void note_content();

  std::string rest_{};  // of the last block: the beginning of a tag
  std::size_t bytes_ = 0;
  bool is_unusual_ = false;
  std::size_t row_ = 0;  // the last one of the repeated rows, from 1
  std::size_t row_repeats_ = 1;
  std::size_t column_ = 0;       // likewise
  std::size_t last_column_ = 0;  // of the sheet, with content
  bool is_behind_gap_ = false;
  bool has_cells_behind_gap_ = false;
  double largest_grid_ = 0.0;
  std::size_t rows_of_largest_ = 0;
  std::size_t columns_of_largest_ = 0;
};

}  // namespace silvafit::source
