// SPDX-License-Identifier: MIT
// Years and dates of measurements.
#pragma once

#include <optional>
#include <string_view>

namespace silvafit::stand {

/// A year or date as a number of years: `2019`, `2019-06-30` or `2019/06/30` (with a time of day or
/// not), `30.06.2019`. A day is 1/365.25 year, so that differences of dates are exact in days;
/// a year alone is its number. None if the text is neither year nor date.
std::optional<double> years_of(std::string_view text);

}  // namespace silvafit::stand
