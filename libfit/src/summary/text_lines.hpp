// SPDX-License-Identifier: MIT
// Lines and numbers of text tables; unknown values are dashes.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string>
#include <utility>

namespace silvafit::fit {

/// Appends formatted text.
template <typename... Values>
void append(std::string& text, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
}

/// With a number of significant digits.
inline std::string significant(double value, int digits = 6) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}g}", value, digits);
}

/// With a number of decimals.
inline std::string decimals(double value, int digits = 4) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

}  // namespace silvafit::fit
