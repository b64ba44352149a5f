// SPDX-License-Identifier: MIT
// Rows of CSV that are written while others are computed, and tables with further columns.
#pragma once

#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>

#include "command.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/ordered_rows.hpp"
#include "silvafit/study/rows_with_columns.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {

inline constexpr char kStreamHelp[] =
    "Read the CSV file in parts, so that memory does not grow with it; if the rows of a plot must "
    "be "
    "together and are not, they are sorted on disk first";

/// Writes rows in the order of the inventory's file, whatever order they come in.
class RowOutput {
 public:
  /// \param out  file; empty: nowhere
  explicit RowOutput(const std::string& out);
  /// \param other  instead of a file; null: nowhere
  explicit RowOutput(std::ostream* other) : stream_(other) {}

  /// The first call writes the header; false if rows are not wanted.
  bool begin(std::string_view header, bool is_in_file_order = true);
  void add(std::size_t line, std::string_view text) { rows_->add(line, text); }
  /// \throws IoError if the rows could not be written
  void finish();

 private:
  std::optional<AtomicFile> file_{};
  std::ostream* stream_ = nullptr;
  std::optional<data::OrderedRows> rows_{};
};

/// Standard output, unless there is a file or --json.
RowOutput file_or_standard_output(const std::string& out, const CommonOptions& common);

using study::AddedColumns;

/// Writes the rows of a table, without titles and units, with new columns at the end. Fields that
/// are not replaced are copied byte for byte. In a file with decimal commas, numbers get decimal
/// points, because commas separate the fields; labels of plots, trees and species are not changed.
class TableWithColumns {
 public:
  /// \param out          CSV file, workbook or layer; empty: standard output, unless there is
  /// --json \param is_in_parts  whether write() is called for several parts \throws UsageError if
  /// parts are to be written as a layer or workbook
  TableWithColumns(const std::string& out,
                   bool is_in_parts,
                   const study::ReadingSettings& reading,
                   const CommonOptions& common);

  /// \param is_in_file_order  the same for all parts
  void write(const data::TableSource& rows, const AddedColumns& columns, bool is_in_file_order);
  /// \param trees  whose coordinate system a layer gets
  void finish(const TreeTable& trees);

 private:
  const std::string& out_;
  const study::ReadingSettings& reading_;
  const CommonOptions& common_;
  std::ostringstream layer_{};
  bool has_header_ = false;
  RowOutput rows_;
};

}  // namespace silvafit::cli
