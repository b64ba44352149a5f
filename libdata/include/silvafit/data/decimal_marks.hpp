// SPDX-License-Identifier: MIT
// Decimal points and decimal commas of the numbers in a column.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::data {

/// The first number of a column with a certain mark.
struct MarkedNumber {
  std::string text{};
  std::size_t line = 0;  ///< 0: there is none
  /// All numbers of the column with this mark could be whole numbers with separated thousands, as
  /// 1.234 or 1,234.
  bool may_be_thousands = true;
};

/// The marks of the numbers in a column of a file in which both marks are read as decimal marks.
struct DecimalMarks {
  MarkedNumber point{};
  MarkedNumber comma{};
  MarkedNumber whole{};  ///< above 0 and below 1000, without a mark
  /// Whole numbers of four and more digits have no separators.
  bool has_long_numbers = false;

  /// Takes a field that was read as a number.
  void add(std::string_view number, std::size_t line);
  bool are_mixed() const { return point.line > 0 && comma.line > 0; }
};

/// Refuses a column of numbers whose marks contradict each other.
/// \throws InputError at the first number with the second mark
void require_one_mark(const DecimalMarks& marks,
                      const std::string& file,
                      const std::string& column);

/// Refuses mixed marks in each column, and columns such as 1.234, 2.345 whose points may separate
/// thousands: if another column has numbers such as 12,5, or if the column also has whole numbers,
/// all below 1000: of numbers with three decimals, few would be written without them.
/// \param columns  those that were read as numbers, by position
/// \throws InputError at the first such number
void require_clear_marks(const std::vector<DecimalMarks>& marks,
                         std::span<const std::size_t> columns,
                         const std::string& file,
                         const std::vector<std::string>& header);

}  // namespace silvafit::data
