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

/// Writes the table of the file without titles and units, byte for byte a field but for the
/// replaced ones, with the new columns behind: into a file, or to standard output, or with --json
/// nowhere. Numbers of a file with decimal commas get points, since commas separate what is
/// written: those of columns of numbers that are no labels of plots, trees or species. \param out
/// file to write; empty: standard output
void write_with_columns(const std::string& in,
                        const std::string& out,
                        const AddedColumns& columns,
                        const CommonOptions& common);

}  // namespace silvafit::cli
