// SPDX-License-Identifier: MIT
#include "table/csv_scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "silvafit/base/system.hpp"
#include "table/formula_guards.hpp"
#include "table/utf8.hpp"

namespace silvafit::data {
namespace {

// A quote that is never closed would otherwise pull the rest of the file into memory.
constexpr std::size_t kLongestRecord = std::size_t{1} << 26;

std::string_view trimmed_of_quotes(std::string_view text) {
  const bool is_quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return is_quoted ? text.substr(1, text.size() - 2) : text;
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

}  // namespace

void CsvScanner::set_separator(char c) {
  separator = c;
  is_field_end = {};
  for (const char end_of_field : {separator, '\r', '\n'}) {
    is_field_end[static_cast<unsigned char>(end_of_field)] = true;
  }
}

void CsvScanner::open() {
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

void CsvScanner::open_text(std::shared_ptr<const TableText> rows) {
  sheet = std::move(rows);
  separator_said = sheet->separator;
  read_more();
}

/// The next bytes of the file or text; fewer than requested at its end.
std::size_t CsvScanner::read_bytes(char* target, std::size_t count) {
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

void CsvScanner::refuse_other_formats() const {
  const std::string_view start(buffer.data() + begin, std::min<std::size_t>(end - begin, 64));
  if (start.starts_with("\x1F\x8B")) {
    fail(1, "the file is compressed (gzip); unpack it first, for example with gunzip");
  }
  if (start.starts_with("PK\x03\x04")) {
    fail(1, "the file is a ZIP archive; the name of a workbook must end in .xlsx or .ods");
  }
  if (looks_like_utf16(start)) {
    fail(1, "there are zero bytes in it: " + advice_on_utf16(start, file));
  }
}

/// Excel writes a line `sep=;` before the header, which gives the separator, and does not show it.
void CsvScanner::take_separator_line() {
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

void CsvScanner::skip_byte_order_mark() {
  // Programs that add a mark to a file that has one leave two.
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  const std::string_view start(buffer.data(), end);
  while (start.substr(begin).starts_with(kMark)) begin += kMark.size();
  if (start.starts_with("\xFF\xFE") || start.starts_with("\xFE\xFF")) {
    fail(1, advice_on_utf16(start, file));
  }
}

void CsvScanner::read_more() {
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
bool CsvScanner::scan_quoted(std::size_t& position) {
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

void CsvScanner::scan_plain(std::size_t& position) {
  const std::size_t start = position;
  const char* const text = buffer.data();
  while (position < end && !ends_field(text[position])) ++position;
  spans.push_back({.begin = start - begin, .end = position - begin});
}

/// Stores the length of the record whose last field ends at the position; false if the block ends
/// between a carriage return and a possible line feed.
bool CsvScanner::end_record(std::size_t position) {
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
bool CsvScanner::scan_record() {
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

void CsvScanner::check_encoding() const {
  const std::size_t zero = std::string_view(buffer.data() + begin, record_length).find('\0');
  if (zero != std::string_view::npos) {
    fail(line_of(zero), "a zero byte, which no text has: the file is damaged; get it again");
  }
  const std::size_t bad = first_invalid_utf8({buffer.data() + begin, record_length});
  if (bad == std::string_view::npos) return;
  const std::string_view bytes(buffer.data() + begin, end - begin);
  fail(line_of(bad),
       fmt::format("byte 0x{:02X} is not UTF-8; {}",
                   static_cast<unsigned char>(buffer[begin + bad]),
                   advice_on_encoding(bytes, file)));
}

bool CsvScanner::is_blank_record() const {
  return std::ranges::all_of(spans, [this](const FieldSpan& span) {
    if (span.quoted) return false;
    return trimmed({buffer.data() + begin + span.begin, span.end - span.begin}).empty();
  });
}

/// Steps over the record found.
void CsvScanner::advance() {
  line = next_line;
  next_line += has_quotes ? count_line_ends({buffer.data() + begin, record_length}) : 1;
  begin += record_length;
}

/// Finds the next record that is not blank and steps over it; its bytes then end at `begin`. False
/// at the end of the file.
bool CsvScanner::find_record() {
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

/// A field of the record found, whose bytes end at `begin`.
std::string_view CsvScanner::field(std::size_t i) {
  const FieldSpan& span = spans[i];
  char* const text = buffer.data() + begin - record_length + span.begin;
  std::size_t length = span.end - span.begin;
  if (span.has_doubled_quotes) length = undouble_quotes(text, length);
  return {text, remove_guards(text, length)};
}

}  // namespace silvafit::data
