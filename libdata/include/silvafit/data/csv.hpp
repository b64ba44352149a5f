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
#include <variant>
#include <vector>

#include "silvafit/data/missing_codes.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// What a file has around its table, as spreadsheets write it.
struct CsvLayout {
  std::size_t titles = 0;            ///< records with titles or comments above the header
  std::size_t header_line = 0;       ///< from 1
  std::size_t comments = 0;          ///< lines with a # below the header, as far as it was read
  std::vector<std::string> units{};  ///< of each column, if a row of units is below the header
};

/// "the header is on line 4, below 3 lines of titles or comments; the row below it has units";
/// empty if there is nothing to say.
std::string describe_layout(const CsvLayout& layout);

/// What the values of a column are in the whole file, of which a part may show less.
enum class ColumnKind { kUnknown, kNumbers, kText };

/// What the parts of a CSV file have in common.
struct TableHead {
  std::vector<std::string> header{};
  CsvLayout layout{};
  std::vector<ColumnKind> kinds{};  ///< of each column; none: kUnknown
};

/// The rows of a sheet or layer as delimited text, one record a line: line n is row n of the sheet.
/// Or a part of a CSV file, as TableParts gives it.
struct TableText {
  std::string name{};  ///< of file and sheet, for messages
  std::string text{};  ///< UTF-8, quoted as in CSV
  char separator = ';';
  /// Of a part: the text is records only, and has no header.
  std::shared_ptr<const TableHead> head{};
  std::vector<std::size_t> lines{};  ///< of a part: line of each record in the file
};

/// A table of a file that distinguishes texts from numbers only by its users' care, such as a
/// layer: a column of texts that are all numbers becomes one of numbers, as in CSV.
struct LayerTable {
  std::shared_ptr<const Table> table{};
};

/// Where rows come from: a CSV file, a table in memory, whose columns keep their types, or what was
/// read from a sheet or layer of another file.
using TableSource = std::variant<std::filesystem::path,
                                 std::shared_ptr<const Table>,
                                 std::shared_ptr<const TableText>,
                                 LayerTable>;

/// The file that a source is, or that its table came from; empty for a table that has none.
std::string file_of(const TableSource& source);

/// Reads a CSV file record by record in blocks, so that memory does not grow with the file.
class CsvReader {
 public:
  /// Opens the file and reads its header.
  ///
  /// Fields are separated as the header's are: by commas, or by semicolons or tabs if there is no
  /// comma; or by what a line `sep=;` before the header says. Titles and comments above the header
  /// and a row of units below it are ignored; docs/inventory.md has the rules.
  /// \param missing  texts that stand for missing values besides those of is_missing_field;
  ///                 numbers among them match any spelling of the number
  /// The rows of a table in memory are records, too: numbers in their shortest spelling, missing
  /// values empty. It has no titles, and its line() is that of its file, or the number of the row.
  /// \throws InputError if the file cannot be read, is empty, or names a column twice
  explicit CsvReader(const TableSource& source, std::vector<std::string> missing = {});
  ~CsvReader();
  CsvReader(CsvReader&&) noexcept;
  CsvReader& operator=(CsvReader&&) noexcept;

  const std::string& file() const;
  /// Where the rows come from, to read them again.
  const TableSource& source() const;

  /// Column names of the header, as written, without surrounding blanks; a line end within a name
  /// is a blank. Columns without a name are empty.
  const std::vector<std::string>& header() const;

  /// Whether a column is text whatever its values are: one of a table in memory that is no layer,
  /// or of a part of a file where another part has text.
  bool is_text(std::size_t column) const;
  /// Whether a column is one of numbers whatever its values are: of a part of a file.
  bool is_numbers(std::size_t column) const;

  /// What is around the table.
  const CsvLayout& layout() const;

  /// From now on an empty field of this column has the value of the last one above that has some,
  /// as merged cells of a spreadsheet mean it.
  void fill_down(std::size_t column);

  /// The next record's fields, unquoted and without_apostrophe; false at the end. Blank lines,
  /// records of blank fields and lines with a comment (#) are ignored, empty fields beyond the
  /// header's are dropped.
  /// The views hold until the next call.
  /// \throws InputError if a quote does not end, bytes are not UTF-8, a record is longer than 64
  /// MiB, or has another number of fields than the header
  bool next(std::vector<std::string_view>& fields);

  /// Whether a field is missing wherever it stands: is_missing_field, or a text given when the file
  /// was opened.
  bool is_missing(std::string_view field) const;

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
      text_columns{};                    ///< columns that stay text even if all values are numbers
  std::vector<std::string> missing{};    ///< as CsvReader has it
  std::vector<std::size_t> fill_down{};  ///< fields to fill down, by position in the header
};

/// A CSV file as a table. A column is numeric if it has a number, and each value is a number or
/// missing: empty, `NA`, or a code of is_missing_number. Else it is text, as it is written but for
/// the blanks around each value. Numbers may have decimal commas as CsvReader says. Columns without
/// a name are left out.
/// \param codes  gets the codes that stood for missing values in columns of numbers
/// \throws InputError if the file cannot be read as CSV, or if a wanted column is not there
Table read_csv_table(const TableSource& source,
                     const CsvTableOptions& options = {},
                     MissingCodes* codes = nullptr);

/// The same for a file of which the header was looked at, and no record: it may be a pipe. The
/// options on missing values and on filling down are those of the reader.
Table read_csv_table(CsvReader& reader,
                     const CsvTableOptions& options,
                     MissingCodes* codes = nullptr);

/// A field without the blanks, tabs, no-break and ideographic spaces around it.
std::string_view trimmed(std::string_view field);

/// True for what counts as missing in a CSV field: nothing, blanks, or NA.
bool is_missing_field(std::string_view field);

/// True for what counts as missing where a number belongs: also -, ., ?, n/a, #N/A, k.A., NaN and
/// the like; docs/inventory.md lists them.
bool is_missing_number(std::string_view field);

/// Reads a whole field as a number, blanks around it allowed; false if it is none. `inf` and `nan`
/// are numbers here: a caller that needs finite numbers has to check this.
bool parse_number(std::string_view field, double& value);

/// A number with a decimal comma, 12,5 or 1,5E-05, with a point in its place; empty if the field is
/// none, as 1.234,5 and 1,2,3.
std::string with_decimal_point(std::string_view field);

/// A field as it is written: quoted where RFC 4180 asks for it, and with an apostrophe before a
/// text that a spreadsheet may take for a formula: one that begins with `=`, `+`, `-` or `@`, also
/// behind blanks and apostrophes. Numbers and codes for missing values get none. CsvReader removes
/// the apostrophe, so that a text is read as it was. Source: OWASP, CSV injection.
std::string csv_field(std::string_view text);

/// The same without apostrophes, for texts that the program makes up, such as -0.25***.
std::string plain_csv_field(std::string_view text);

/// A text as it was before csv_field gave it an apostrophe.
std::string_view without_apostrophe(std::string_view field);

/// Writes a table as CSV: numbers in their shortest form, missing values empty, lines ended by \n.
void write_csv_table(const Table& table, std::ostream& stream);
/// The same into a file, whole or not at all.
void write_csv_table(const Table& table, const std::filesystem::path& path);

}  // namespace silvafit::data
