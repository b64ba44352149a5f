// SPDX-License-Identifier: MIT
#include "trees/column_times.hpp"

#include <fmt/format.h>

#include <optional>

namespace silvafit::stand {

std::string ColumnTimes::read(std::string_view plot, std::string_view time, const Place& where) {
  std::string text = with_year_first(time, place_);
  if (text == time) return text;
  if (first_.empty()) first_ = time;
  if (place_ != DayPlace::kUnknown) return text;
  // Days compare by one of the two readings, without times of day.
  const std::string date = with_year_first(time, DayPlace::kFirst);
  const auto [known, is_new] = date_in_year_.try_emplace({std::string(plot), text}, date);
  if (is_new || known->second == date) return text;
  throw InputError(fmt::format("'{}' may be day/month/year or month/day/year, no date of the "
                               "column decides it, and the plot has another date in {}; write "
                               "dates as 2019-06-30",
                               time,
                               text),
                   where);
}

std::string ColumnTimes::note() const {
  if (first_.empty()) return {};
  if (place_ == DayPlace::kUnknown) {
    return fmt::format(
        "dates such as {} may be day/month/year or month/day/year, and only their "
        "years are used; write them as 2019-06-30 to use the days",
        first_);
  }
  return fmt::format("dates such as {} are read as {}",
                     first_,
                     place_ == DayPlace::kFirst ? "day/month/year" : "month/day/year");
}

double required_years_of(const std::string& time, const Place& where) {
  if (const std::optional<double> years = years_of(time)) return *years;
  const bool is_short =
      time.size() == 2 && time.find_first_not_of("0123456789") == std::string::npos;
  throw InputError(
      time.empty() ? std::string("the year or date is missing")
                   : fmt::format("'{}' is not a year or date, such as 2019, 06/2019, 2019-06-30, "
                                 "30.06.2019 or 30/06/2019{}",
                                 time,
                                 is_short ? fmt::format("; if it is a year without its century, "
                                                        "use `columns=year=\"20\" + {}`",
                                                        where.column)
                                          : std::string()),
      where);
}

}  // namespace silvafit::stand
