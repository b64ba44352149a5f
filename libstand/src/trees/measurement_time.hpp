// SPDX-License-Identifier: MIT
// Years and dates of measurements.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::stand {

/// A year or date as a number of years: `2019`, `2019-06-30` or `2019/06/30` (with a time of day or
/// not), `20190630`, `30.06.2019`. A day is 1/365.25 year, so that differences of dates are exact
/// in days; a year alone is its number. None if the text is neither year nor date.
std::optional<double> years_of(std::string_view text);

/// The place of a time in a list of times; a year is the time of any date in it, and the other way
/// round. None if there is no such time.
std::optional<std::size_t> same_time(const std::vector<std::string>& times, std::string_view time);
/// The same for times by years_of().
std::optional<std::size_t> same_time(const std::vector<double>& years, double time);
/// Whether times are less than half a day apart.
bool is_same_time(double left, double right);

/// The label of a plot at a time, "7 (2019)".
std::string label_at_time(std::string_view plot, std::string_view time);

}  // namespace silvafit::stand
