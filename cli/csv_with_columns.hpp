// SPDX-License-Identifier: MIT
// A CSV file as it is, with columns behind it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"

namespace silvafit::cli {

/// Columns to add to a file of N rows, and values to put in place of its own.
struct AddedColumns {
  std::vector<std::string> names{};
  /// The new fields of a row, one a name.
  std::function<std::vector<std::string>(std::size_t row)> fields{};
  std::string replaced{};  ///< a column of the file whose fields may change; empty: none
  /// The field of that column in a row; empty where the file's own stays.
  std::function<std::string(std::size_t row)> replacement{};
  std::vector<std::string> fill_down{};  ///< of --fill-down
  std::vector<std::string> mapped{};     ///< of --columns
};

/// Writes the table of the file without titles and units, with the new columns at the end. Fields
/// that are not replaced are copied byte for byte. The table goes to a file or to standard output;
/// with --json it is not written. In a file with decimal commas, numbers get decimal points,
/// because commas separate the fields; labels of plots, trees and species are not changed.
/// \param out  file to write; empty: standard output
void write_with_columns(const std::string& in,
                        const std::string& out,
                        const AddedColumns& columns,
                        const CommonOptions& common);

}  // namespace silvafit::cli
