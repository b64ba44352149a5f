// SPDX-License-Identifier: MIT
// CSV files larger than memory, in parts.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"

namespace silvafit::data {

struct TablePartsOptions {
  /// Field, by position in the header, whose equal values stay in one part; none: rows are
  /// independent.
  std::optional<std::size_t> group{};
  std::vector<std::string> missing{};    ///< as CsvReader has it
  std::vector<std::size_t> fill_down{};  ///< fields to fill down, by position in the header
  bool finds_kinds = true;               ///< else TableHead has none
  std::size_t rows = 200000;  ///< a part ends with the first group that makes it so large
};

/// A CSV file in parts of whole groups, so that memory does not grow with the file.
///
/// The file is read twice: first to find what only the whole file shows, which columns are text and
/// whether the rows of each group follow each other; then in parts. If they do not, the rows are
/// sorted on disk by group (ExternalSort); groups come in the order of their first rows. A table of
/// a part is what the rows have in the table of the whole file. Memory: a part, and about
/// 50 bytes for each group.
/// \throws InputError if the file cannot be read, or only once; IoError if the disk fails
class TableParts {
 public:
  TableParts(const std::filesystem::path& path, const TablePartsOptions& options);
  ~TableParts();
  TableParts(TableParts&&) noexcept;
  TableParts& operator=(TableParts&&) noexcept;

  /// Whether the rows come in another order than that of the file; TableText::lines has it.
  bool is_sorted() const;
  std::size_t rows() const;
  /// The next part; nothing after the last. A file without rows has one part without rows.
  std::shared_ptr<const TableText> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Fields as a record of a part, with its line end.
/// \param record  gets the bytes at its end
void append_record(const std::vector<std::string_view>& fields,
                   char separator,
                   std::string& record);

}  // namespace silvafit::data
