// SPDX-License-Identifier: MIT
// The rows of a CSV file with further columns at their end.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// Columns to add to a file of N rows.
struct AddedColumns {
  data::Table table{};
  int digits = 17;  ///< significant ones of numbers
  /// A column of the table that replaces that of the file of this name, if there is one, in the
  /// given rows; empty: none.
  std::string replaced{};
  std::function<bool(std::size_t row)> is_replaced{};
};

/// Receives a record with its line end, and its line in the file; 0 for the header.
using RecordSink = std::function<void(std::size_t line, std::string_view record)>;

/// Yields the rows of a file, without titles and units, with the new columns at the end. Fields
/// that are not replaced are copied byte for byte. In a file with decimal commas, numbers get
/// decimal points, because commas separate the fields; labels of plots, trees and species are not
/// changed.
void write_rows_with_columns(const data::TableSource& in,
                             const AddedColumns& columns,
                             const ReadingSettings& reading,
                             const RecordSink& sink);

/// The rows of write_rows_with_columns() as a table.
data::Table rows_with_columns(const data::TableSource& in,
                              const AddedColumns& columns,
                              const ReadingSettings& reading);

/// The table of a CSV text with commas; labels of plots, trees and species are texts.
data::Table labeled_table(std::string text, const std::string& file);

/// \throws InputError if a file has a column of one of these names already
void refuse_known_columns(const std::vector<std::string>& names,
                          const std::vector<std::string>& header,
                          const std::string& file);

/// The number rounded to so many significant digits, without zeros at its end; with 17 the shortest
/// text that reads back as the same number.
std::string with_digits(double value, int digits);

}  // namespace silvafit::study
