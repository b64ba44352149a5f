// SPDX-License-Identifier: MIT
// A copy of a CSV file with further columns at its end.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "command.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {

/// Columns to add to a file of N rows.
struct AddedColumns {
  data::Table table{};
  int digits = 17;  ///< significant ones of numbers
  /// A column of the table that goes into that of the file, if it has one of this name, in the rows
  /// that are told; empty: none.
  std::string replaced{};
  std::function<bool(std::size_t row)> is_replaced{};
};

/// Writes the table of the file without titles and units, with the new columns at the end. Fields
/// that are not replaced are copied byte for byte. The table goes to a file or to standard output;
/// with --json it is not written. In a file with decimal commas, numbers get decimal points,
/// because commas separate the fields; labels of plots, trees and species are not changed.
/// \param out  CSV file, workbook or layer to write; empty: standard output
void write_with_columns(const TreeTable& in,
                        const std::string& out,
                        const AddedColumns& columns,
                        const study::ReadingSettings& reading,
                        const CommonOptions& common);

}  // namespace silvafit::cli
