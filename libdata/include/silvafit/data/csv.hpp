// SPDX-License-Identifier: MIT
// CSV files (RFC 4180): UTF-8 with or without a byte order mark, any line end, quoted fields; also
// files with semicolons or tabs and decimal commas, which spreadsheets write in many languages.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "silvafit/data/decimal_marks.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// The lines of a file around its table: titles, comments and units.
struct CsvLayout {
  std::size_t titles = 0;            ///< records with titles or comments above the header
  std::size_t header_line = 0;       ///< from 1
  std::size_t comments = 0;          ///< lines with # below the header, in the part read so far
  std::vector<std::string> units{};  ///< of each column, if there is a row of units
  /// Columns that have values but no name, with the first value, in the part read so far.
  std::vector<std::string> unnamed{};
};

/// "the header is on line 4, below 3 lines of titles or comments; the row below it has units";
/// empty for a plain file.
std::string describe_layout(const CsvLayout& layout);

/// The type of a column in the whole file. A part of the file may not show it.
enum class ColumnKind { kUnknown, kNumbers, kText };

/// The common properties of all parts of a CSV file.
struct TableHead {
  std::vector<std::string> header{};
  CsvLayout layout{};
  std::vector<ColumnKind> kinds{};  ///< of each column; kUnknown if empty
  /// Of each column in the whole file, whatever its kind; none if the file has decimal points.
  std::vector<DecimalMarks> marks{};
};

/// The rows of a sheet or layer as delimited text, one record per line: line n is row n of the
/// sheet. Also a part of a CSV file (see TableParts).
struct TableText {
  std::string name{};  ///< of the file and the sheet, for messages
  std::string text{};  ///< UTF-8, quoted as in CSV
  char separator = ';';
  /// Of a part, whose text contains records only, without a header.
  std::shared_ptr<const TableHead> head{};
  std::vector<std::size_t> lines{};  ///< of a part: the line of each record in the file
};

/// A table of a layer, whose text columns often contain numbers. A text column that contains
/// numbers only becomes numeric, as in CSV.
struct LayerTable {
  std::shared_ptr<const Table> table{};
};

/// A source of rows: a CSV file, a table in memory, whose columns keep their types, or the content
/// of a sheet or layer of another file.
using TableSource = std::variant<std::filesystem::path,
                                 std::shared_ptr<const Table>,
                                 std::shared_ptr<const TableText>,
                                 LayerTable>;

/// The file of a source; empty for a table without a file.
std::string file_of(const TableSource& source);

/// Reads a CSV file record by record, in blocks, so that memory does not depend on its size.
class CsvReader {
 public:
  /// Opens the file and reads its header.
  ///
  /// The separator is the one of the header: a comma, or a semicolon or tab if there is no comma,
  /// or the one given by a line `sep=;` before the header. Titles and comments above the header and
  /// a row of units below it are skipped (docs/inventory.md has the rules).
  ///
  /// The rows of a table in memory are records, too: numbers in their shortest spelling, missing
  /// values empty. Such a source has no titles; line() is the line in the table's file, or the
  /// number of the row.
  /// \param missing  texts for missing values, in addition to those of is_missing_field; a number
  ///                 also matches its other spellings
  /// \throws InputError if the file cannot be read, is empty, or has two columns with one name
  explicit CsvReader(const TableSource& source, std::vector<std::string> missing = {});
  ~CsvReader();
  CsvReader(CsvReader&&) noexcept;
  CsvReader& operator=(CsvReader&&) noexcept;

  const std::string& file() const;
  /// The source, for reading it again.
  const TableSource& source() const;

  /// The names of the columns without surrounding blanks. A line end within a name is replaced by a
  /// blank. The name of an unnamed column is empty.
  const std::vector<std::string>& header() const;

  /// Whether a column is text whatever its values are: a text column of a table in memory, or a
  /// column with text in another part of the file.
  bool is_text(std::size_t column) const;
  /// Whether a column is numeric whatever its values are, because the whole file is known.
  bool is_numbers(std::size_t column) const;

  const CsvLayout& layout() const;

  /// From now on, replaces an empty field of a column by the last value above it: the meaning of
  /// merged cells in a spreadsheet.
  void fill_down(std::size_t column);

  /// Reads the fields of the next record, without quotes and without the apostrophes that csv_field
  /// adds. Skips blank lines, records of blank fields, and comments (#), and drops empty fields to
  /// the right of the header's.
  /// \param fields  valid until the next call
  /// \returns false at the end
  /// \throws InputError if a quote is not closed, the text is not UTF-8, or a record is longer than
  ///   64 MiB or has another number of fields than the header
  bool next(std::vector<std::string_view>& fields);

  /// Whether a field is a missing value in any column: by is_missing_field, or one of the texts
  /// given to the constructor.
  bool is_missing(std::string_view field) const;

  /// Whether 12,5 is read as the number 12.5, because the separator is a semicolon or tab. Text
  /// keeps its spelling: 1,2 and 1.2 are two different plots.
  bool has_decimal_commas() const;
  /// Reads a whole field as a number, with a decimal comma if the file has these.
  /// \returns false if the field is not a number
  bool parse_number(std::string_view field, double& value) const;

  /// The same for a field of the last record, whose decimal mark is noted.
  bool read_number(std::size_t column, std::string_view field, double& value);
  /// Refuses a column in which read_number found points and commas.
  /// \throws InputError with the line
  void require_one_mark(std::size_t column) const;
  /// Refuses such columns, and those whose marks may separate thousands (require_clear_marks).
  /// \param columns  those that are used as numbers
  void require_clear_marks(std::span<const std::size_t> columns) const;
  /// The marks that read_number found; none if the file has decimal points.
  const std::vector<DecimalMarks>& marks() const;

  /// The first line of the last record, from 1.
  std::size_t line() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

struct CsvTableOptions {
  std::vector<std::string> columns{};  ///< columns to keep; empty means all
  std::vector<std::string>
      text_columns{};                    ///< columns that stay text even if all values are numbers
  std::vector<std::string> missing{};    ///< see CsvReader
  std::vector<std::size_t> fill_down{};  ///< columns to fill down, by position in the header
};

/// Reads a CSV file as a table. A column is numeric if it contains numbers and otherwise only
/// missing values: empty fields, `NA`, or codes of is_missing_number. Any other column is text,
/// without the blanks around each value. For decimal commas see CsvReader. Unnamed columns are
/// omitted.
/// \param codes  the codes of missing values in numeric columns are added to it
/// \throws InputError if the file cannot be read as CSV, or if a requested column does not exist
Table read_csv_table(const TableSource& source,
                     const CsvTableOptions& options = {},
                     MissingCodes* codes = nullptr);

/// The same for a file whose header was read, but no record; it may be a pipe. The options for
/// missing values and filling down are those of the reader.
Table read_csv_table(CsvReader& reader,
                     const CsvTableOptions& options,
                     MissingCodes* codes = nullptr);

/// A field without surrounding blanks, tabs, no-break spaces and ideographic spaces.
std::string_view trimmed(std::string_view field);

/// Whether a field is missing in any column: empty, blanks, or NA.
bool is_missing_field(std::string_view field);

/// Whether a field is missing in a numeric column: also -, ., ?, n/a, #N/A, k.A., NaN and similar
/// codes (listed in docs/inventory.md).
bool is_missing_number(std::string_view field);

/// Reads a whole field, without surrounding blanks, as a number. Accepts `inf` and `nan`: a caller
/// that needs a finite number must check this.
/// \returns false if the field is not a number
bool parse_number(std::string_view field, double& value);

/// Replaces the comma of a number with a decimal comma, such as 12,5 or 1,5E-05, by a point. Empty
/// for any other field, such as 1.234,5 or 1,2,3.
std::string with_decimal_point(std::string_view field);

/// A text as a field of a CSV file: in quotes if RFC 4180 requires them, and with an apostrophe
/// before a text that a spreadsheet may evaluate as a formula, because it begins with `=`, `+`, `-`
/// or `@`, possibly after blanks and apostrophes. Numbers and codes of missing values get no
/// apostrophe. CsvReader removes it, so that the text is read unchanged.
/// Source: OWASP, CSV injection.
std::string csv_field(std::string_view text);

/// The same without apostrophes, for texts of the program itself, such as -0.25***.
std::string plain_csv_field(std::string_view text);

/// Writes a table as CSV: numbers in their shortest form, missing values as empty fields, \n as
/// line end.
void write_csv_table(const Table& table, std::ostream& stream);
/// The same to a file, which is complete or not written at all.
void write_csv_table(const Table& table, const std::filesystem::path& path);

}  // namespace silvafit::data
