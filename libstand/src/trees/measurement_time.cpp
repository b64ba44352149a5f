// SPDX-License-Identifier: MIT
#include "trees/measurement_time.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/words.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/data/text_formula.hpp"

namespace silvafit::stand {
namespace {

/// Three whole numbers separated by two equal signs.
struct DateParts {
  int first = 0;
  int second = 0;
  int third = 0;
};

std::optional<int> digits_of(std::string_view text) {
  if (text.empty() || text.size() > 4) return std::nullopt;
  int value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + (c - '0');
  }
  return value;
}

std::optional<DateParts> parts_at(std::string_view text, char sign) {
  const std::size_t first = text.find(sign);
  const std::size_t second = text.find(sign, first + 1);
  if (first == std::string_view::npos || second == std::string_view::npos) return std::nullopt;
  const auto a = digits_of(text.substr(0, first));
  const auto b = digits_of(text.substr(first + 1, second - first - 1));
  const auto c = digits_of(text.substr(second + 1));
  if (!a || !b || !c) return std::nullopt;
  return DateParts{*a, *b, *c};
}

/// The century of the year 98 is not known.
constexpr int kFirstYear = 1000;

constexpr int kMonths = 12;

std::optional<double> years_of_day(int year, int month, int day) {
  using namespace std::chrono;
  if (year < kFirstYear) return std::nullopt;
  const year_month_day date{std::chrono::year(year),
                            std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  constexpr double kDaysPerYear = 365.25;
  constexpr double kYearOfDayZero = 1970.0;
  const auto days = sys_days(date).time_since_epoch().count();
  return kYearOfDayZero + static_cast<double>(days) / kDaysPerYear;
}

/// 06/2019 or 06-2019; a point would be that of a decimal.
std::optional<double> years_of_month(std::string_view date) {
  const std::size_t sign = date.find_first_of("/-");
  if (sign == std::string_view::npos) return std::nullopt;
  const auto month = digits_of(date.substr(0, sign));
  const auto year = digits_of(date.substr(sign + 1));
  constexpr int kMiddle = 15;
  if (!month || !year || *month > kMonths) return std::nullopt;
  return years_of_day(*year, *month, kMiddle);
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A text without its time of day.
std::string_view date_in(std::string_view text) {
  text = data::trimmed(text);
  for (std::size_t i = 1; i < text.size(); ++i) {
    // The month of 05-OCT-2019 has a T, too.
    if ((text[i] == ' ' || text[i] == 'T') && is_digit(text[i - 1])) return text.substr(0, i);
  }
  return text;
}

/// 2019-AUG-05, 05-Aug-2019 or 5/August/2019 with the month as a number and the year first; empty
/// if it is none.
std::string with_numbered_month(std::string_view date) {
  const auto is_letter = [](char c) { return (c | 0x20) >= 'a' && (c | 0x20) <= 'z'; };
  if (std::ranges::none_of(date, is_letter)) return {};
  constexpr std::string_view kNames = "janfebmaraprmayjunjulaugsepoctnovdec";
  constexpr std::size_t kLetters = 3;
  for (const char sign : {'-', '/', '.', ' '}) {
    const std::vector<std::string_view> parts = data::split_at(date, sign);
    if (parts.size() != 3 || parts[1].size() < kLetters) continue;
    const std::string name = in_lower_case(parts[1].substr(0, kLetters));
    const std::size_t month = kNames.find(name);
    auto year = digits_of(parts[0]);
    auto day = digits_of(parts[2]);
    if (month == std::string_view::npos || month % kLetters != 0 || !year || !day) continue;
    if (*year < kFirstYear) std::swap(year, day);
    return fmt::format("{:04}-{:02}-{:02}", *year, month / kLetters + 1, *day);
  }
  return {};
}

/// The parts of a date whose year is the last number, and whose day may be any of the others.
std::optional<DateParts> parts_with_year_last(std::string_view text) {
  for (const char sign : {'/', '-'}) {
    const auto parts = parts_at(date_in(text), sign);
    if (parts && parts->third >= kFirstYear) return parts;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> years_of(std::string_view text) {
  text = data::trimmed(text);
  const std::string_view date = date_in(text);
  for (const std::string_view part : {text, date}) {
    if (const std::string numbered = with_numbered_month(part); !numbered.empty()) {
      return years_of(numbered);
    }
  }
  for (const char sign : {'-', '/'}) {
    if (const auto parts = parts_at(date, sign); parts && date.find(sign) == 4) {
      return years_of_day(parts->first, parts->second, parts->third);
    }
  }
  if (const auto parts = parts_at(date, '.')) {
    return years_of_day(parts->third, parts->second, parts->first);
  }
  if (const auto month = years_of_month(date)) return month;
  constexpr std::size_t kDigitsOfDay = 8;  // 20190630
  if (text.size() == kDigitsOfDay) {
    const auto own_year = digits_of(text.substr(0, 4));
    const auto month = digits_of(text.substr(4, 2));
    const auto day = digits_of(text.substr(6));
    if (own_year && month && day) return years_of_day(*own_year, *month, *day);
  }
  double year = 0.0;
  if (data::parse_number(text, year) && year >= 1000.0 && year < 3000.0) return year;
  return std::nullopt;
}

DayPlace day_place(const std::vector<std::string>& times) {
  bool is_other_date = false;
  for (const std::string& time : times) {
    const auto parts = parts_with_year_last(time);
    if (!parts) continue;
    if (parts->first > kMonths) return DayPlace::kFirst;
    if (parts->second > kMonths) return DayPlace::kSecond;
    is_other_date = is_other_date || parts->first != parts->second;
  }
  return is_other_date ? DayPlace::kUnknown : DayPlace::kFirst;
}

std::string with_year_first(std::string_view time, DayPlace place) {
  const auto parts = parts_with_year_last(time);
  if (!parts) return std::string(time);
  if (place == DayPlace::kUnknown) return fmt::format("{}", parts->third);
  const bool is_day_first = place == DayPlace::kFirst;
  const int day = is_day_first ? parts->first : parts->second;
  const int month = is_day_first ? parts->second : parts->first;
  if (!years_of_day(parts->third, month, day)) return std::string(time);
  return fmt::format("{}-{:02}-{:02}", parts->third, month, day);
}

bool is_year(double years) { return years == std::floor(years); }

bool is_same_time(double left, double right) {
  constexpr double kHalfADay = 0.5 / 365.25;
  return std::abs(left - right) < kHalfADay;
}

std::optional<std::size_t> same_time(const std::vector<double>& years, double time) {
  for (std::size_t i = 0; i < years.size(); ++i) {
    if (is_same_time(years[i], time)) return i;
  }
  for (std::size_t i = 0; i < years.size(); ++i) {
    const bool has_year = is_year(years[i]) != is_year(time);
    if (has_year && std::floor(years[i]) == std::floor(time)) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> same_time(const std::vector<std::string>& times, std::string_view time) {
  const std::optional<double> own = years_of(time);
  if (!own) return std::nullopt;
  // Texts that are no times are no times of any plot.
  std::vector<double> years;
  for (const std::string& text : times) years.push_back(years_of(text).value_or(data::kMissing));
  return same_time(years, *own);
}

std::string label_at_time(std::string_view plot, std::string_view time) {
  return fmt::format("{} ({})", plot, time);
}

}  // namespace silvafit::stand
