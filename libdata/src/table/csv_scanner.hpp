// SPDX-License-Identifier: MIT
// Finds the records and fields of a CSV file.
#pragma once

#include <array>
#include <cstddef>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "table/csv_layout.hpp"

namespace silvafit::data {

/// A field's bytes within its record, without the quotes around it.
struct FieldSpan {
  std::size_t begin = 0;
  std::size_t end = 0;
  bool quoted = false;
  bool has_doubled_quotes = false;
};

/// A CSV file record by record. A block of the file is in memory; a record that reaches beyond it
/// is scanned again when more has been read, so that fields are always contiguous.
struct CsvScanner {
  static constexpr std::size_t kBlock = std::size_t{1} << 18;

  std::string file;
  std::shared_ptr<const TableText> sheet{};  // instead of the file
  std::size_t sheet_read = 0;
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

  [[noreturn]] void fail(std::size_t at_line, const std::string& message) const {
    throw InputError(message, {.file = file, .line = at_line});
  }
  void open();
  void open_text(std::shared_ptr<const TableText> rows);
  void set_separator(char c);
  bool find_record();
  std::string_view field(std::size_t i);

 private:
  std::size_t line_of(std::size_t offset_in_record) const {
    return next_line + count_line_ends({buffer.data() + begin, offset_in_record});
  }
  bool ends_field(char c) const { return is_field_end[static_cast<unsigned char>(c)]; }
  std::size_t read_bytes(char* target, std::size_t count);
  void skip_byte_order_mark();
  void refuse_other_formats() const;
  void take_separator_line();
  void read_more();
  bool scan_record();
  bool scan_quoted(std::size_t& position);
  void scan_plain(std::size_t& position);
  bool end_record(std::size_t position);
  void check_encoding() const;
  bool is_blank_record() const;
  void advance();
};

}  // namespace silvafit::data
