// SPDX-License-Identifier: MIT
// Counts of the codes of missing values, such as -, n/a or -999, for a note.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::data {

/// Counts by column, in the order of the first calls.
class MissingCodes {
 public:
  void add(std::string_view column, std::string_view code, std::size_t count = 1);
  bool empty() const { return columns_.empty(); }
  /// "h 12 (-, n/a), cw 3 (0)"
  std::string text() const;

 private:
  struct Column {
    std::string name{};
    std::size_t count = 0;
    std::vector<std::string> codes{};
  };
  std::vector<Column> columns_{};
};

}  // namespace silvafit::data
