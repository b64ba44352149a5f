// SPDX-License-Identifier: MIT
// Tables record by record: header, rows of units, comments, and tables in memory.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "table/csv_layout.hpp"
#include "table/csv_scanner.hpp"

namespace silvafit::data {
namespace {

/// The text with blanks for line ends.
std::string in_one_line(std::string_view text) {
  std::string line(text);
  std::erase(line, '\r');
  std::ranges::replace(line, '\n', ' ');
  return line;
}

/// A column of a table in memory.
struct SourceColumn {
  std::span<const double> numbers{};
  const TextColumn* text = nullptr;  ///< null for numbers
};

}  // namespace

struct CsvReader::State : CsvScanner {
  TableSource source{};
  std::shared_ptr<const Table> table{};  // instead of the file
  bool keeps_types = false;              // of the table's columns
  std::size_t sheet_records = 0;
  std::vector<SourceColumn> columns{};  // of the table
  std::size_t next_row = 0;
  std::vector<std::string> cells{};  // of the last row
  std::vector<std::string> header{};
  CsvLayout layout{};
  std::vector<std::size_t> unnamed{};  // columns without name, and without a value so far
  bool skips_next = false;             // a row of units comes
  std::vector<std::string> missing{};
  std::vector<double> missing_numbers{};
  std::vector<std::pair<std::size_t, std::string>> filled_down{};  // column, last value
  std::vector<DecimalMarks> marks{};  // of each column; none if there are no decimal commas

  void find_start();
  void read_header();
  void refuse_other_separators(std::string_view names) const;
  void take_head(const TableHead& head);
  ColumnKind kind(std::size_t column) const;
  bool is_ignored();
  void fit_to_header();
  void note_unnamed_values(std::span<const std::string_view> fields);
  void take_table();
  bool take_row(std::vector<std::string_view>& fields);
};

/// Steps over titles and comments, and finds what separates the fields.
void CsvReader::State::find_start() {
  const TableStart start =
      start_of_table({buffer.data() + begin, end - begin}, at_end_of_file, separator_said);
  set_separator(start.separator);
  begin += start.bytes_above;
  next_line += start.lines_above;
  layout.titles = start.titles;
  layout.units = start.units;
  skips_next = !start.units.empty();
}

/// A line that is one field may have other separators.
void CsvReader::State::refuse_other_separators(std::string_view names) const {
  const std::string_view rest(buffer.data() + begin, end - begin);
  const std::string_view values = rest.substr(0, rest.find_first_of("\r\n"));
  const auto words = [](std::string_view text) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != ' ' && (i == 0 || text[i - 1] == ' ')) ++count;
    }
    return count;
  };
  constexpr std::size_t kFewestColumns = 3;
  const bool has_bars = std::ranges::count(names, '|') > 0;
  const bool has_blanks = words(names) >= kFewestColumns && words(names) == words(values);
  if (!has_bars && !has_blanks) return;
  fail(line,
       fmt::format("the columns seem to be separated by {}; save the table with commas, semicolons "
                   "or tabs",
                   has_bars ? "'|'" : "blanks"));
}

void CsvReader::State::read_header() {
  find_start();
  if (!find_record())
    throw InputError("the file is empty; a header line is needed", {.file = file});
  layout.header_line = line;
  std::unordered_map<std::string, std::size_t> first_with_name;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    header.emplace_back(trimmed(in_one_line(field(i))));
    if (header.back().empty()) {
      // The first one has the row names of R's write.csv() or the index of pandas.
      if (i > 0) unnamed.push_back(i);
      continue;
    }
    const auto [first, is_new] = first_with_name.try_emplace(header.back(), header.size());
    if (!is_new) {
      fail(line,
           fmt::format("columns {} and {} have the same name '{}'",
                       first->second,
                       header.size(),
                       header.back()));
    }
  }
  if (header.size() == 1) refuse_other_separators(header.front());
}

/// The header of a part of a file.
void CsvReader::State::take_head(const TableHead& head) {
  set_separator(sheet->separator);
  header = head.header;
  layout = head.layout;
  marks = head.marks;
}

ColumnKind CsvReader::State::kind(std::size_t column) const {
  if (!sheet || !sheet->head || sheet->head->kinds.empty()) return ColumnKind::kUnknown;
  return sheet->head->kinds[column];
}

/// Whether the record found is the row of units or a comment.
bool CsvReader::State::is_ignored() {
  if (std::exchange(skips_next, false)) return true;
  const char first = buffer[begin - record_length];
  if (first != '#' || spans.size() != 1 || header.size() == 1) return false;
  ++layout.comments;
  return true;
}

/// Drops blank fields beyond those of the header.
void CsvReader::State::fit_to_header() {
  const char* const record = buffer.data() + begin - record_length;
  while (spans.size() > header.size()) {
    const FieldSpan& last = spans.back();
    if (!trimmed({record + last.begin, last.end - last.begin}).empty()) break;
    spans.pop_back();
  }
  if (spans.size() == header.size()) return;
  fail(line,
       fmt::format("fields found: {}, columns in the header: {}", spans.size(), header.size()));
}

/// Keeps the first value of each column that has no name.
void CsvReader::State::note_unnamed_values(std::span<const std::string_view> fields) {
  std::erase_if(unnamed, [&](std::size_t column) {
    const std::string_view value = trimmed(fields[column]);
    if (value.empty()) return false;
    layout.unnamed.push_back(fmt::format("column {} ('{}' in line {})", column + 1, value, line));
    return true;
  });
}

void CsvReader::State::take_table() {
  header = table->names();
  if (header.empty()) throw InputError("the table has no columns", {.file = file});
  for (const std::string& name : header) {
    const bool is_numeric = table->is_numeric(name);
    columns.push_back({.numbers = is_numeric ? table->numbers(name) : std::span<const double>(),
                       .text = is_numeric ? nullptr : &table->text(name)});
  }
  cells.resize(header.size());
}

/// The fields of the table's next row; false after the last.
bool CsvReader::State::take_row(std::vector<std::string_view>& fields) {
  if (next_row == table->rows()) return false;
  const std::size_t row = next_row++;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const SourceColumn& column = columns[i];
    if (column.text != nullptr) {
      cells[i] = (*column.text)[row];
    } else {
      cells[i] = std::isnan(column.numbers[row]) ? std::string() : shortest(column.numbers[row]);
    }
    fields.emplace_back(cells[i]);
  }
  line = table->line(row) > 0 ? table->line(row) : row + 1;
  return true;
}

std::string file_of(const TableSource& source) {
  if (const auto* const path = std::get_if<std::filesystem::path>(&source)) return path->string();
  if (const auto* const text = std::get_if<std::shared_ptr<const TableText>>(&source)) {
    return (*text)->name;
  }
  if (const auto* const layer = std::get_if<LayerTable>(&source)) return layer->table->file();
  return std::get<std::shared_ptr<const Table>>(source)->file();
}

CsvReader::CsvReader(const TableSource& source, std::vector<std::string> missing)
    : state_(std::make_unique<State>()) {
  state_->source = source;
  state_->file = file_of(source);
  state_->missing = std::move(missing);
  for (const std::string& text : state_->missing) {
    double value = 0.0;
    if (data::parse_number(text, value)) state_->missing_numbers.push_back(value);
  }
  if (const auto* const table = std::get_if<std::shared_ptr<const Table>>(&source)) {
    state_->table = *table;
    state_->keeps_types = true;
  } else if (const auto* const layer = std::get_if<LayerTable>(&source)) {
    state_->table = layer->table;
  }
  if (state_->table) {
    state_->take_table();
    return;
  }
  const auto* const text = std::get_if<std::shared_ptr<const TableText>>(&source);
  text != nullptr ? state_->open_text(*text) : state_->open();
  const bool is_part = text != nullptr && (*text)->head;
  is_part ? state_->take_head(*(*text)->head) : state_->read_header();
  if (has_decimal_commas()) state_->marks.resize(state_->header.size());
}

CsvReader::~CsvReader() = default;
CsvReader::CsvReader(CsvReader&&) noexcept = default;
CsvReader& CsvReader::operator=(CsvReader&&) noexcept = default;

const std::string& CsvReader::file() const { return state_->file; }

const TableSource& CsvReader::source() const { return state_->source; }

const std::vector<std::string>& CsvReader::header() const { return state_->header; }

bool CsvReader::is_text(std::size_t column) const {
  if (state_->kind(column) == ColumnKind::kText) return true;
  return state_->keeps_types && state_->columns[column].text != nullptr;
}

bool CsvReader::is_numbers(std::size_t column) const {
  return state_->kind(column) == ColumnKind::kNumbers;
}

const CsvLayout& CsvReader::layout() const { return state_->layout; }

void CsvReader::fill_down(std::size_t column) { state_->filled_down.emplace_back(column, ""); }

bool CsvReader::is_missing(std::string_view field) const {
  if (is_missing_field(field)) return true;
  if (state_->missing.empty()) return false;
  const std::string_view text = trimmed(field);
  if (std::ranges::find(state_->missing, text) != state_->missing.end()) return true;
  double value = 0.0;
  if (state_->missing_numbers.empty() || !parse_number(text, value)) return false;
  return std::ranges::find(state_->missing_numbers, value) != state_->missing_numbers.end();
}

std::size_t CsvReader::line() const { return state_->line; }

bool CsvReader::has_decimal_commas() const { return state_->separator != ','; }

bool CsvReader::parse_number(std::string_view field, double& value) const {
  if (data::parse_number(field, value)) return true;
  if (!has_decimal_commas()) return false;
  const std::string with_point = with_decimal_point(field);
  return !with_point.empty() && data::parse_number(with_point, value);
}

bool CsvReader::read_number(std::size_t column, std::string_view field, double& value) {
  if (!parse_number(field, value)) return false;
  if (!state_->marks.empty()) state_->marks[column].add(field, state_->line);
  return true;
}

void CsvReader::require_one_mark(std::size_t column) const {
  if (state_->marks.empty()) return;
  data::require_one_mark(state_->marks[column], state_->file, state_->header[column]);
}

void CsvReader::require_clear_marks(std::span<const std::size_t> columns) const {
  if (state_->marks.empty()) return;
  data::require_clear_marks(state_->marks, columns, state_->file, state_->header);
}

const std::vector<DecimalMarks>& CsvReader::marks() const { return state_->marks; }

bool CsvReader::next(std::vector<std::string_view>& fields) {
  State& state = *state_;
  fields.clear();
  if (state.table) {
    if (!state.take_row(fields)) return false;
  } else {
    do {
      if (!state.find_record()) return false;
    } while (state.is_ignored());
    if (state.sheet && state.sheet->head) state.line = state.sheet->lines[state.sheet_records++];
    state.fit_to_header();
    for (std::size_t i = 0; i < state.spans.size(); ++i) fields.push_back(state.field(i));
    state.note_unnamed_values(fields);
  }
  for (auto& [column, last] : state.filled_down) {
    const std::string_view own = trimmed(fields[column]);
    own.empty() ? void(fields[column] = last) : void(last = own);
  }
  return true;
}

}  // namespace silvafit::data
