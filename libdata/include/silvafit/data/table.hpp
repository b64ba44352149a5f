// SPDX-License-Identifier: MIT
// Tables of named columns of numbers or text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace silvafit::data {

/// The missing value of numeric columns.
inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// A column of text. Each row contains the index of one of the distinct values ("levels"), or
/// kMissingCode.
class TextColumn {
 public:
  static constexpr std::uint32_t kMissingCode = 0xffffffffU;

  void reserve(std::size_t rows) { codes_.reserve(rows); }
  void append(std::string_view value);
  void append_missing() { codes_.push_back(kMissingCode); }

  std::size_t size() const { return codes_.size(); }
  bool is_missing(std::size_t row) const { return codes_[row] == kMissingCode; }
  std::uint32_t code(std::size_t row) const { return codes_[row]; }
  /// The text of a row; empty if it is missing.
  std::string_view operator[](std::size_t row) const;
  /// Distinct values in the order of their first appearance.
  const std::vector<std::string>& levels() const { return levels_; }
  /// The code of a value, or kMissingCode if it is not a level.
  std::uint32_t code_of(std::string_view value) const;

 private:
  /// The index of a value in slots_, or of the free slot for it.
  std::size_t slot_of(std::string_view value) const;
  void grow_slots();

  std::vector<std::uint32_t> codes_;
  std::vector<std::string> levels_;
  /// Hash table with open addressing: codes, or kMissingCode in free slots. At most half full.
  std::vector<std::uint32_t> slots_;
};

/// Named columns of equal length. Text from a file keeps its spelling ("07" remains "07"); missing
/// numbers are NaN.
class Table {
 public:
  Table() = default;
  explicit Table(std::size_t rows) : rows_(rows), has_size_(true) {}

  std::size_t rows() const { return rows_; }
  /// Names in column order.
  const std::vector<std::string>& names() const { return names_; }
  bool has(std::string_view name) const;
  bool is_numeric(std::string_view name) const;

  /// \throws UsageError if there is no such column, or it is text
  std::span<const double> numbers(std::string_view name) const;
  /// \throws UsageError if there is no such column, or it is numeric
  const TextColumn& text(std::string_view name) const;
  /// A column as text; numbers by shortest().
  /// \throws UsageError if there is no such column
  TextColumn labels(std::string_view name) const;

  /// Adds a column, or replaces the one with this name.
  /// \throws UsageError if its length differs from that of the table
  void set(std::string_view name, std::vector<double> values);
  void set(std::string_view name, TextColumn values);

  /// A table of the given rows, in the given order.
  Table select(std::span<const std::size_t> row_numbers) const;

  /// The file of the table, for messages; empty if there is none.
  const std::string& file() const { return file_; }
  /// First line of a row in the file, from 1; 0 if the table is not from a file.
  std::size_t line(std::size_t row) const { return row < lines_.size() ? lines_[row] : 0; }
  void set_origin(std::string file, std::vector<std::uint32_t> lines);

 private:
  struct Slot {
    bool numeric = true;
    std::size_t index = 0;
  };
  const Slot& slot(std::string_view name) const;
  Slot& slot_for(std::string_view name, std::size_t length);

  std::size_t rows_ = 0;
  bool has_size_ = false;
  std::vector<std::string> names_;
  std::unordered_map<std::string, Slot> slots_;
  std::vector<std::vector<double>> numeric_;
  std::vector<TextColumn> text_;
  std::string file_;
  std::vector<std::uint32_t> lines_;
};

/// A list of names for a message: the first forty, and the number of others.
std::string list_of(std::span<const std::string> names);

/// The error message for a column that does not exist.
std::string no_such_column(std::string_view name, std::span<const std::string> names);

/// The shortest decimal text from which the same double is read.
std::string shortest(double value);

}  // namespace silvafit::data
