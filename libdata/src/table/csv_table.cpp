// SPDX-License-Identifier: MIT
// CSV files as tables, in memory proportional to the columns kept.
#include <algorithm>
#include <cstdint>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::data {
namespace {

/// A code for a missing value, which is a text if the column turns out to be one.
struct CodeCell {
  std::size_t row = 0;
  std::string code{};
  bool is_missing_in_text = false;
};

/// A column while it is read. It is numeric until the first value that is not a number.
struct ColumnBuilder {
  std::string name{};
  std::size_t field = 0;
  bool is_text = false;
  bool has_numbers = false;
  std::vector<CodeCell> codes{};
  /// Text that came after numbers: how those were spelled ("07") is lost, so a second pass over the
  /// file reads the column as text from the start.
  bool needs_second_pass = false;
  std::vector<double> numbers{};
  TextColumn text{};

  void append(std::string_view value, CsvReader& reader);
  void become_text();
  void finish(MissingCodes* counts);
};

void ColumnBuilder::append(std::string_view value, CsvReader& reader) {
  if (needs_second_pass) return;
  if (reader.is_missing(value)) {
    // Those of --missing are counted, empty fields and NA are not.
    if (!is_text && !is_missing_field(value)) {
      codes.push_back({numbers.size(), std::string(trimmed(value)), true});
    }
    is_text ? text.append_missing() : numbers.push_back(kMissing);
    return;
  }
  double number = 0.0;
  if (!is_text && reader.read_number(field, value, number)) {
    has_numbers = true;
    numbers.push_back(number);
    return;
  }
  if (!is_text && is_missing_number(value)) {
    codes.push_back({numbers.size(), std::string(trimmed(value))});
    numbers.push_back(kMissing);
    return;
  }
  if (!is_text) become_text();
  if (!needs_second_pass) text.append(trimmed(value));
}

void ColumnBuilder::become_text() {
  is_text = true;
  needs_second_pass = has_numbers;
  auto code = codes.begin();
  for (std::size_t i = 0; i < numbers.size() && !needs_second_pass; ++i) {
    const bool is_code = code != codes.end() && code->row == i;
    const bool is_value = is_code && !code->is_missing_in_text;
    is_value ? text.append(code->code) : text.append_missing();
    if (is_code) ++code;
  }
  numbers = {};
  codes = {};
}

/// After the last row: a column of codes alone is text.
void ColumnBuilder::finish(MissingCodes* counts) {
  if (is_text) return;
  const auto is_text_code = [](const CodeCell& cell) { return !cell.is_missing_in_text; };
  if (!has_numbers && std::ranges::any_of(codes, is_text_code)) return become_text();
  for (const CodeCell& cell : codes) {
    if (counts != nullptr) counts->add(name, cell.code);
  }
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::vector<ColumnBuilder> wanted_columns(const CsvReader& reader, const CsvTableOptions& options) {
  const std::vector<std::string>& header = reader.header();
  std::unordered_map<std::string_view, std::size_t> field_of;
  for (std::size_t i = 0; i < header.size(); ++i) field_of.emplace(header[i], i);
  std::vector<ColumnBuilder> columns;
  for (const std::string& name : options.columns.empty() ? header : options.columns) {
    if (name.empty()) continue;
    const auto found = field_of.find(name);
    if (found == field_of.end())
      throw InputError(no_such_column(name, header), {.file = reader.file()});
    const std::size_t field = found->second;
    const bool is_text = contains(options.text_columns, name) || reader.is_text(field);
    const bool has_numbers = !is_text && reader.is_numbers(field);
    columns.push_back(
        {.name = name, .field = field, .is_text = is_text, .has_numbers = has_numbers});
  }
  return columns;
}

std::vector<std::uint32_t> read_columns(CsvReader& reader, std::vector<ColumnBuilder>& columns) {
  std::vector<std::uint32_t> lines;
  std::vector<std::string_view> fields;
  while (reader.next(fields)) {
    lines.push_back(static_cast<std::uint32_t>(reader.line()));
    for (ColumnBuilder& column : columns) column.append(fields[column.field], reader);
  }
  return lines;
}

/// Labels such as 1.2 and 1,2 keep their spelling; only numbers need clear marks.
void require_clear_marks(const CsvReader& reader, const std::vector<ColumnBuilder>& columns) {
  std::vector<std::size_t> numeric;
  for (const ColumnBuilder& column : columns) {
    if (!column.is_text) numeric.push_back(column.field);
  }
  reader.require_clear_marks(numeric);
}

void read_again_as_text(const TableSource& source,
                        const CsvTableOptions& options,
                        std::vector<ColumnBuilder>& columns) {
  std::vector<ColumnBuilder*> again;
  for (ColumnBuilder& column : columns) {
    if (!std::exchange(column.needs_second_pass, false)) continue;
    column.text = {};
    again.push_back(&column);
  }
  if (again.empty()) return;
  const auto* const path = std::get_if<std::filesystem::path>(&source);
  if (path != nullptr && !std::filesystem::is_regular_file(*path)) {
    throw InputError(
        "contains numbers and then text; a stream cannot be read twice, so give a file",
        {.file = path->string(), .column = again.front()->name});
  }
  CsvReader reader(source, options.missing);
  for (const std::size_t field : options.fill_down) reader.fill_down(field);
  std::vector<std::string_view> fields;
  while (reader.next(fields)) {
    for (ColumnBuilder* column : again) column->append(fields[column->field], reader);
  }
}

}  // namespace

Table read_csv_table(const TableSource& source,
                     const CsvTableOptions& options,
                     MissingCodes* codes) {
  CsvReader reader(source, options.missing);
  for (const std::size_t field : options.fill_down) reader.fill_down(field);
  return read_csv_table(reader, options, codes);
}

Table read_csv_table(CsvReader& reader, const CsvTableOptions& options, MissingCodes* codes) {
  std::vector<ColumnBuilder> columns = wanted_columns(reader, options);
  std::vector<std::uint32_t> lines = read_columns(reader, columns);
  read_again_as_text(reader.source(), options, columns);

  for (ColumnBuilder& column : columns) column.finish(codes);
  require_clear_marks(reader, columns);
  Table table(lines.size());
  for (ColumnBuilder& column : columns) {
    if (column.is_text) {
      table.set(column.name, std::move(column.text));
    } else {
      table.set(column.name, std::move(column.numbers));
    }
  }
  table.set_origin(reader.file(), std::move(lines));
  return table;
}

}  // namespace silvafit::data
