// SPDX-License-Identifier: MIT
// Numbers in tables for people; unknown values are dashes.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace silvafit::cli {

/// With so many significant digits.
inline std::string significant(double value, int digits = 6) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}g}", value, digits);
}

/// With so many digits behind the point.
inline std::string decimals(double value, int digits = 4) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

}  // namespace silvafit::cli
