// SPDX-License-Identifier: MIT
// A copy of a CSV file with further columns at its end.
#pragma once

#include <optional>
#include <ostream>
#include <string>

#include "command.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/ordered_rows.hpp"
#include "silvafit/study/rows_with_columns.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {

using study::AddedColumns;

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

inline constexpr char kStreamHelp[] =
    "Read the CSV file in parts, so that memory does not grow with it; if the rows of a plot must "
    "be "
    "together and are not, they are sorted on disk first";

/// As above for a file that is read in parts.
class PartsWithColumns {
 public:
  /// \param out  CSV file to write; empty: standard output, unless there is --json
  /// \throws UsageError if it is a layer or workbook, because these are written as a whole
  PartsWithColumns(const std::string& out,
                   const study::ReadingSettings& reading,
                   const CommonOptions& common);

  /// The rows of a part, with their columns.
  /// \param is_in_file_order  the same for all parts
  void write(const data::TableSource& rows, const AddedColumns& columns, bool is_in_file_order);
  void finish();

 private:
  const study::ReadingSettings& reading_;
  std::optional<AtomicFile> file_{};
  std::ostream* stream_ = nullptr;
  std::optional<data::OrderedRows> rows_{};
};

}  // namespace silvafit::cli
