// SPDX-License-Identifier: MIT
// Number formats of Excel, which make dates of numbers.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace silvafit::source {

enum class NumberFormat { kNumber, kPercentage, kDate, kTime };

/// The kind of a format by its code, such as `dd/mm/yyyy`, `[h]:mm` or `0.0%`.
/// Source: ECMA-376 part 1, 18.8.31.
NumberFormat format_of_code(std::string_view code);

/// The kind of a format that has a number and no code in the file (the same source, 18.8.30).
NumberFormat format_of_number(int number);

/// A number as the date or time that its cell shows, in the format of ISO 8601: days since the end
/// of 1899, with a day for the 29 February 1900 that did not exist, or since 1904-01-01.
/// \return none if it is not between these and the year 9999
std::optional<std::string> date_text(double days, NumberFormat format, bool is_since_1904);

}  // namespace silvafit::source
