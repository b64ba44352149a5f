// SPDX-License-Identifier: MIT
// Years and dates of measurements.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace silvafit::stand {

/// Years between the last day of one campaign and the first one of the next, at least.
inline constexpr double kBetweenVisits = 0.25;

/// The longest time within which trees are measured for one inventory [years]: two winters.
inline constexpr double kLongestCampaign = 1.5;

/// A year or date as a number of years: `2019`, `2019-06-30` or `2019/06/30` (with a time of day or
/// not), `20190630`, `30.06.2019`, `2019-JUN-30`, `30 June 2019`. A day is 1/365.25 year, so that
/// differences of dates are exact in days; a year alone is its number, and a month (`06/2019`) is
/// its middle. None if the text is neither year nor date.
std::optional<double> years_of(std::string_view text);

/// Which number of dates such as 5/6/2019 or 5-6-2019 is the day.
enum class DayPlace { kUnknown, kFirst, kSecond };

/// The place of the day in a column of times, by the first date with a number above 12. Without
/// one it is unknown, unless both places give the same dates.
DayPlace day_place(const std::vector<std::string>& times);

/// A date such as 5/6/2019 as 2019-06-05 or 2019-05-06, or as its year if the place of the day is
/// unknown. Other texts, and dates that do not exist, stay as they are.
std::string with_year_first(std::string_view time, DayPlace place);

/// The place of a time in a list of times; a year is the time of any date in it, and the other way
/// round. None if there is no such time.
std::optional<std::size_t> same_time(const std::vector<std::string>& times, std::string_view time);
/// The same for times by years_of().
std::optional<std::size_t> same_time(const std::vector<double>& years, double time);
/// Whether a time is a year alone.
bool is_year(double years);
/// Whether times are less than half a day apart.
bool is_same_time(double left, double right);

/// The label of a plot at a time, "7 (2019)".
std::string label_at_time(std::string_view plot, std::string_view time);

}  // namespace silvafit::stand
