// SPDX-License-Identifier: MIT
// Reading CSV files that are larger than memory in parts.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"

namespace silvafit::data {

struct TablePartsOptions {
  /// Columns, by position in the header, whose groups of equal values are not divided; none if rows
  /// are independent.
  std::vector<std::size_t> group{};
  std::vector<std::string> missing{};    ///< see CsvReader
  std::vector<std::size_t> fill_down{};  ///< columns to fill down, by position in the header
  bool finds_kinds = true;               ///< whether TableHead has the types of columns
  std::size_t rows = 200000;             ///< a part ends with the group that reaches this number
  /// If rows must not be sorted: called with the line and label of a group that comes again after
  /// its part, and throws.
  std::function<void(std::size_t line, const std::string& label)> refuse_group{};
};

/// Reads a CSV file in parts of complete groups, so that memory does not depend on its size.
///
/// The file is read twice: first to find the columns of text, and whether the rows of each group
/// are contiguous; then in parts. If they are not contiguous, the rows are sorted on disk by group
/// (ExternalSort), with the groups in the order of their first rows. The tables of the parts have
/// the values and types of the table of the whole file. Memory: one part, and about 50 bytes per
/// group.
/// \throws InputError if the file cannot be read, or not twice; IoError if the disk fails
class TableParts {
 public:
  TableParts(const std::filesystem::path& path, const TablePartsOptions& options);
  /// Parts of what a reader has not read yet, such as a pipe: in one pass, with types unknown.
  /// \param options  with refuse_group
  TableParts(CsvReader reader, const TablePartsOptions& options);
  ~TableParts();
  TableParts(TableParts&&) noexcept;
  TableParts& operator=(TableParts&&) noexcept;

  /// Whether the order of the rows differs from that of the file, which TableText::lines gives.
  bool is_sorted() const;
  std::size_t rows() const;
  /// The next part; null after the last one. A file without rows has one part without rows.
  std::shared_ptr<const TableText> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Appends fields to the text of a part, as a record with its line end.
void append_record(const std::vector<std::string_view>& fields,
                   char separator,
                   std::string& record);

}  // namespace silvafit::data
