// SPDX-License-Identifier: MIT
// CSV files record by record. A block of the file is in memory; a record that reaches beyond it is
// scanned again when more has been read, so that fields are always contiguous.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/system.hpp"
#include "silvafit/data/csv.hpp"
#include "table/csv_layout.hpp"
#include "table/formula_guards.hpp"
#include "table/utf8.hpp"

namespace silvafit::data {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 18;
// A quote that is never closed would otherwise pull the rest of the file into memory.
constexpr std::size_t kLongestRecord = std::size_t{1} << 26;

/// A field's bytes within its record, without the quotes around it.
struct FieldSpan {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool quoted = false;
  bool has_doubled_quotes = false;
};

std::string_view trimmed_of_quotes(std::string_view text) {
  const bool is_quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return is_quoted ? text.substr(1, text.size() - 2) : text;
}

/// The text with blanks for line ends.
std::string in_one_line(std::string_view text) {
  std::string line(text);
  std::erase(line, '\r');
  std::ranges::replace(line, '\n', ' ');
  return line;
}

/// Turns doubled quotes into single ones in place; returns the new length.
std::size_t undouble_quotes(char* text, std::size_t length) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < length; ++i, ++kept) {
    text[kept] = text[i];
    if (text[i] == '"') ++i;
  }
  return kept;
}

/// A column of a table in memory.
struct SourceColumn {
  std::span<const double> numbers{};
  const TextColumn* text = nullptr;  ///< null for numbers
};

}  // namespace

struct CsvReader::State {
  TableSource source{};
  std::string file;
  std::shared_ptr<const Table> table{};      // instead of the file
  bool keeps_types = false;                  // of the table's columns
  std::shared_ptr<const TableText> sheet{};  // instead of the file
  std::size_t sheet_read = 0;
  std::size_t sheet_records = 0;
  std::vector<SourceColumn> columns{};  // of the table
  std::size_t next_row = 0;
  std::vector<std::string> cells{};  // of the last row
  std::ifstream stream;
  std::vector<char> buffer = std::vector<char>(kBlock);
  std::size_t begin = 0;  // of the next record
  std::size_t end = 0;    // of the bytes read so far
  bool at_end_of_file = false;

  char separator = ',';                  // of fields
  std::array<bool, 256> is_field_end{};  // for each byte: the separator and line ends
  std::optional<char> separator_said{};  // by a line before the header
  std::vector<FieldSpan> spans{};        // of the record found, relative to its first byte
  std::size_t record_length = 0;         // with its line end
  bool has_quotes = false;               // somewhere in the record
  std::size_t line = 0;                  // of the record found
  std::size_t next_line = 1;
  std::vector<std::string> header{};
  CsvLayout layout{};
  bool skips_next = false;  // a row of units comes
  std::vector<std::string> missing{};
  std::vector<double> missing_numbers{};
  std::vector<std::pair<std::size_t, std::string>> filled_down{};  // column, last value
  std::vector<DecimalMarks> marks{};  // of each column; none if there are no decimal commas

  [[noreturn]] void fail(std::size_t at_line, const std::string& message) const {
    throw InputError(message, {.file = file, .line = at_line});
  }

  std::size_t line_of(std::size_t offset_in_record) const {
    return next_line + count_line_ends({buffer.data() + begin, offset_in_record});
  }

  bool ends_field(char c) const { return is_field_end[static_cast<unsigned char>(c)]; }
  void set_separator(char c) {
    separator = c;
    is_field_end = {};
    for (const char end_of_field : {separator, '\r', '\n'}) {
      is_field_end[static_cast<unsigned char>(end_of_field)] = true;
    }
  }

  void open();
  void open_text(std::shared_ptr<const TableText> rows);
  std::size_t read_bytes(char* target, std::size_t count);
  void skip_byte_order_mark();
  void refuse_other_formats() const;
  void take_separator_line();
  void read_more();
  bool scan_record();
  bool scan_quoted(std::size_t& position);
  void scan_plain(std::size_t& position);
  bool end_record(std::size_t position);
  bool find_record();
  void check_encoding() const;
  bool is_blank_record() const;
  void advance();
  void find_start();
  void read_header();
  void take_head(const TableHead& head);
  ColumnKind kind(std::size_t column) const;
  bool is_ignored();
  void fit_to_header();
  void take_table();
  bool take_row(std::vector<std::string_view>& fields);
  std::string_view field(std::size_t i);
};

void CsvReader::State::open() {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) {
    throw InputError("is a folder; a CSV file is needed", {.file = file});
  }
  stream.open(std::filesystem::path(file), std::ios::binary);
  if (!stream)
    throw InputError(fmt::format("cannot be read: {}", system::reason(errno)), {.file = file});
  read_more();
  skip_byte_order_mark();
  refuse_other_formats();
  take_separator_line();
}

void CsvReader::State::open_text(std::shared_ptr<const TableText> rows) {
  sheet = std::move(rows);
  separator_said = sheet->separator;
  read_more();
}

/// The next bytes of the file or text; fewer than requested at its end.
std::size_t CsvReader::State::read_bytes(char* target, std::size_t count) {
  if (sheet) {
    const std::size_t taken = sheet->text.copy(target, count, sheet_read);
    sheet_read += taken;
    at_end_of_file = sheet_read == sheet->text.size();
    return taken;
  }
  stream.read(target, static_cast<std::streamsize>(count));
  if (stream.bad()) throw InputError("reading failed", {.file = file});
  at_end_of_file = stream.eof();
  return static_cast<std::size_t>(stream.gcount());
}

void CsvReader::State::refuse_other_formats() const {
  const std::string_view start(buffer.data() + begin, std::min<std::size_t>(end - begin, 64));
  if (start.starts_with("\x1F\x8B")) {
    fail(1, "the file is compressed (gzip); unpack it first, for example with gunzip");
  }
  if (start.starts_with("PK\x03\x04")) {
    fail(1, "the file is a ZIP archive; the name of a workbook must end in .xlsx or .ods");
  }
  if (start.find('\0') != std::string_view::npos) {
    fail(1, "there are zero bytes in it: " + advice_on_utf16(start, file));
  }
}

/// Excel writes a line `sep=;` before the header, which gives the separator, and does not show it.
void CsvReader::State::take_separator_line() {
  const std::string_view text(buffer.data() + begin, end - begin);
  const std::string_view line_text = text.substr(0, text.find_first_of("\r\n"));
  std::string_view content = trimmed_of_quotes(line_text);
  if (content.size() != 5 || !(content.starts_with("sep=") || content.starts_with("SEP="))) return;
  separator_said = content.back();
  begin += line_text.size();
  if (begin < end && buffer[begin] == '\r') ++begin;
  if (begin < end && buffer[begin] == '\n') ++begin;
  ++next_line;
}

void CsvReader::State::skip_byte_order_mark() {
  // Programs that add a mark to a file that has one leave two.
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  const std::string_view start(buffer.data(), end);
  while (start.substr(begin).starts_with(kMark)) begin += kMark.size();
  if (start.starts_with("\xFF\xFE") || start.starts_with("\xFE\xFF")) {
    fail(1, advice_on_utf16(start, file));
  }
}

void CsvReader::State::read_more() {
  std::memmove(buffer.data(), buffer.data() + begin, end - begin);
  end -= begin;
  begin = 0;
  if (end == buffer.size()) {
    if (buffer.size() >= kLongestRecord) {
      fail(next_line,
           fmt::format(
               "the record that starts here is longer than {} MiB; is a closing quote missing?",
               kLongestRecord >> 20));
    }
    buffer.resize(2 * buffer.size());
  }
  end += read_bytes(buffer.data() + end, buffer.size() - end);
}

/// Reads a quoted field up to the character after its closing quote; false if the block ends before
/// that.
bool CsvReader::State::scan_quoted(std::size_t& position) {
  const std::size_t start = position + 1;
  FieldSpan span{.begin = start - begin, .quoted = true};
  has_quotes = true;
  for (position = start;;) {
    const void* const quote = std::memchr(buffer.data() + position, '"', end - position);
    if (quote == nullptr) {
      if (!at_end_of_file) return false;
      fail(line_of(span.begin), "the quoted field that starts here has no closing quote");
    }
    position = static_cast<std::size_t>(static_cast<const char*>(quote) - buffer.data()) + 1;
    if (position == end && !at_end_of_file) return false;
    if (position == end || buffer[position] != '"') break;
    span.has_doubled_quotes = true;
    ++position;
  }
  span.end = position - 1 - begin;
  spans.push_back(span);
  if (position < end && !ends_field(buffer[position])) {
    fail(line_of(position - begin),
         "text follows a closing quote; double the quotes inside a quoted field");
  }
  return true;
}

void CsvReader::State::scan_plain(std::size_t& position) {
  const std::size_t start = position;
  const char* const text = buffer.data();
  while (position < end && !ends_field(text[position])) ++position;
  spans.push_back({.begin = start - begin, .end = position - begin});
}

/// Stores the length of the record whose last field ends at the position; false if the block ends
/// between a carriage return and a possible line feed.
bool CsvReader::State::end_record(std::size_t position) {
  std::size_t after = position;
  if (after < end && buffer[after] == '\r') {
    ++after;
    if (after == end && !at_end_of_file) return false;
    if (after < end && buffer[after] == '\n') ++after;
  } else if (after < end) {
    ++after;
  }
  record_length = after - begin;
  return true;
}

/// Finds the fields of the record at `begin`; false if the block ends before the record does.
bool CsvReader::State::scan_record() {
  spans.clear();
  has_quotes = false;
  std::size_t position = begin;
  for (;;) {
    if (position < end && buffer[position] == '"') {
      if (!scan_quoted(position)) return false;
    } else {
      scan_plain(position);
    }
    if (position == end && !at_end_of_file) return false;
    if (position == end || buffer[position] != separator) return end_record(position);
    ++position;
  }
}

void CsvReader::State::check_encoding() const {
  const std::size_t bad = first_invalid_utf8({buffer.data() + begin, record_length});
  if (bad == std::string_view::npos) return;
  const std::string_view bytes(buffer.data() + begin, end - begin);
  fail(line_of(bad),
       fmt::format("byte 0x{:02X} is not UTF-8; {}",
                   static_cast<unsigned char>(buffer[begin + bad]),
                   advice_on_encoding(bytes, file)));
}

bool CsvReader::State::is_blank_record() const {
  return std::ranges::all_of(spans, [this](const FieldSpan& span) {
    if (span.quoted) return false;
    return trimmed({buffer.data() + begin + span.begin, span.end - span.begin}).empty();
  });
}

/// Steps over the record found.
void CsvReader::State::advance() {
  line = next_line;
  next_line += has_quotes ? count_line_ends({buffer.data() + begin, record_length}) : 1;
  begin += record_length;
}

/// Finds the next record that is not blank and steps over it; its bytes then end at `begin`. False
/// at the end of the file.
bool CsvReader::State::find_record() {
  for (;;) {
    if (begin == end && at_end_of_file) return false;
    if (!scan_record()) {
      read_more();
      continue;
    }
    check_encoding();
    const bool is_blank = is_blank_record();
    advance();
    if (!is_blank) return true;
  }
}

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

/// A field of the record found, whose bytes end at `begin`.
std::string_view CsvReader::State::field(std::size_t i) {
  const FieldSpan& span = spans[i];
  char* const text = buffer.data() + begin - record_length + span.begin;
  std::size_t length = span.end - span.begin;
  if (span.has_doubled_quotes) length = undouble_quotes(text, length);
  return {text, remove_guards(text, length)};
}

void CsvReader::State::read_header() {
  find_start();
  if (!find_record())
    throw InputError("the file is empty; a header line is needed", {.file = file});
  layout.header_line = line;
  std::unordered_map<std::string, std::size_t> first_with_name;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    header.emplace_back(trimmed(in_one_line(field(i))));
    if (header.back().empty()) continue;
    const auto [first, is_new] = first_with_name.try_emplace(header.back(), header.size());
    if (!is_new) {
      fail(line,
           fmt::format("columns {} and {} have the same name '{}'",
                       first->second,
                       header.size(),
                       header.back()));
    }
  }
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
  }
  for (auto& [column, last] : state.filled_down) {
    const std::string_view own = trimmed(fields[column]);
    own.empty() ? void(fields[column] = last) : void(last = own);
  }
  return true;
}

}  // namespace silvafit::data
