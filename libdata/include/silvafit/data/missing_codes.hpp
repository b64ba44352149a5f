// SPDX-License-Identifier: MIT
// Codes of missing values, such as -, n/a or -9999, and their counts for a note.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::data {

/// Whether a number means a missing value in every column: -9999 or -99999.
bool is_missing_code(double value);
/// Whether it often does, in columns without other negative values: -9, -99 or -999.
bool is_likely_missing_code(double value);
/// Whether a number is written with nines only, of either sign, and is at least 9: 99.9, -999.
bool is_all_nines(double value);

/// A value that may be a code: a likely one that is the only negative value, or one at the end of a
/// column that is 99 or more, written with nines only, such as 999 or 99.9, repeated, and far from
/// all others.
/// \param values  NaN where missing
/// \param zero    whether a repeated 0 far from all others may be a code, too
std::optional<double> possible_code(std::span<const double> values, bool zero = false);

/// \throws InputError at the place if there is a possible_code(), with the settings that answer
void refuse_possible_code(std::span<const double> values, Place place);

/// Counts by column, in the order of the first calls.
class MissingCodes {
 public:
  void add(std::string_view column, std::string_view code, std::size_t count = 1);
  bool empty() const { return columns_.empty(); }
  /// "h 12 (-, n/a), cw 3 (0)"
  std::string text() const;
  /// "codes read as missing values: h 12 (-, n/a), cw 3 (0)"; empty if there are none.
  std::string note() const;

 private:
  struct Column {
    std::string name{};
    std::size_t count = 0;
    std::vector<std::string> codes{};
  };
  std::vector<Column> columns_{};
};

/// Makes the codes of is_missing_code() missing in all columns of numbers.
/// \param found  gets them
void take_missing_codes(Table& table, MissingCodes& found);

}  // namespace silvafit::data
