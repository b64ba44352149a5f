// SPDX-License-Identifier: MIT
// CSV files (RFC 4180): UTF-8 with or without byte order mark, any line end, quoted fields. Also
// those with semicolons or tabs and decimal commas, as spreadsheets of many languages write them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// Reads a CSV file record by record in blocks, so that memory does not grow with the file.
class CsvReader {
 public:
  /// Opens the file and reads its header.
  ///
  /// Fields are separated as the header's are: by commas, or by semicolons or tabs if there is no
  /// comma; or by what a line `sep=;` before the header says.
  /// \throws InputError if the file cannot be read, is empty, or names a column twice
  explicit CsvReader(const std::filesystem::path& path);
  ~CsvReader();
  CsvReader(CsvReader&&) noexcept;
  CsvReader& operator=(CsvReader&&) noexcept;

  const std::string& file() const;

  /// Column names of the header, as written, without surrounding blanks.
  const std::vector<std::string>& header() const;

  /// The next record's fields, unquoted; false at the end. Blank lines are passed over.
  /// The views hold until the next call.
  /// \throws InputError if a quote does not end, bytes are not UTF-8, a record is longer than 64
  /// MiB, or has another number of fields than the header
  bool next(std::vector<std::string_view>& fields);

  /// Whether semicolons or tabs separate, so that 12,5 is the number 12.5 where a number is looked
  /// for. Text keeps its spelling: plots 1,2 and 1.2 are two.
  bool has_decimal_commas() const;
  /// Reads a whole field as a number, as the function of this name does, or one with a decimal
  /// comma if the file has such; false if it is none.
  bool parse_number(std::string_view field, double& value) const;

  /// Line on which the last record began, from 1.
  std::size_t line() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct CsvTableOptions {
  std::vector<std::string> columns{};  ///< columns to keep; empty means all
  std::vector<std::string>
      text_columns{};  ///< columns that stay text even if all values are numbers
};

/// A CSV file as a table. A column is numeric if each value is a number or missing (empty or `NA`),
/// else text, as it is written but for the blanks around each value. Numbers may have decimal
/// commas as CsvReader says.
/// \throws InputError if the file cannot be read as CSV, or if a wanted column is not there
Table read_csv_table(const std::filesystem::path& path, const CsvTableOptions& options = {});

/// The same for a file of which the header was looked at, and no record: it may be a pipe.
Table read_csv_table(CsvReader& reader, const CsvTableOptions& options);

/// A field without the blanks and tabs around it.
std::string_view trimmed(std::string_view field);

/// True for what counts as missing in a CSV field: nothing, blanks, or NA.
bool is_missing_field(std::string_view field);

/// Reads a whole field as a number, blanks around it allowed; false if it is none. `inf` and `nan`
/// are numbers here: whoever needs finite ones says so with a message of their own.
bool parse_number(std::string_view field, double& value);

/// A number with a decimal comma, 12,5 or 1,5E-05, with a point in its place; empty if the field is
/// none, as 1.234,5 and 1,2,3.
std::string with_decimal_point(std::string_view field);

/// A field as it is written: quoted where RFC 4180 asks for it.
std::string csv_field(std::string_view text);

/// Writes a table as CSV: numbers in their shortest form, missing values empty, lines ended by \n.
void write_csv_table(const Table& table, std::ostream& stream);
/// The same into a file, whole or not at all.
void write_csv_table(const Table& table, const std::filesystem::path& path);

}  // namespace silvafit::data
