// SPDX-License-Identifier: MIT
#include "workbook/excel_formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>

namespace silvafit::source {
namespace {

/// The letters and signs of a code that stand for parts of the value, without quoted texts,
/// escaped characters, widths, fillings, and colors or languages in brackets.
std::string meaning_of(std::string_view code) {
  std::string meaning;
  for (std::size_t i = 0; i < code.size(); ++i) {
    const char c = code[i];
    if (c == '"' || c == '[') {
      const std::size_t end = std::min(code.find(c == '"' ? '"' : ']', i + 1), code.size());
      const std::string_view inside = code.substr(i + 1, end - i - 1);
      // [h], [mm], [s]: elapsed time.
      if (c == '[' && inside.find_first_not_of("hmsHMS") == std::string_view::npos) meaning += 'h';
      i = end;
    } else if (c == '\\' || c == '_' || c == '*') {
      ++i;
    } else {
      meaning += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return meaning;
}

}  // namespace

NumberFormat format_of_code(std::string_view code) {
  const std::string meaning = meaning_of(code);
  const auto has = [&meaning](std::string_view any) {
    return meaning.find_first_of(any) != std::string::npos;
  };
  // Other letters, as in General, belong to words. A/P and AM/PM, e, g and b are parts of dates.
  const bool has_words = std::ranges::any_of(meaning, [](unsigned char c) {
    return std::isalpha(c) != 0 &&
           std::string_view("ymdhsapegb").find(static_cast<char>(c)) == std::string_view::npos;
  });
  if (has_words) return NumberFormat::kNumber;
  if (has("yd") || (has("m") && !has("hs"))) return NumberFormat::kDate;
  if (has("hs")) return NumberFormat::kTime;
  return has("%") ? NumberFormat::kPercentage : NumberFormat::kNumber;
}

NumberFormat format_of_number(int number) {
  const auto is_within = [number](int low, int high) { return number >= low && number <= high; };
  if (is_within(9, 10)) return NumberFormat::kPercentage;
  if (is_within(18, 21) || is_within(45, 47) || is_within(32, 35)) return NumberFormat::kTime;
  if (is_within(14, 22) || is_within(27, 36) || is_within(50, 58)) return NumberFormat::kDate;
  return NumberFormat::kNumber;
}

std::optional<std::string> date_text(double days, NumberFormat format, bool is_since_1904) {
  constexpr double kMostDays = 2958466.0;  // 10000-01-01
  constexpr double kDaysTo1904 = 1462.0;
  constexpr double kSecondsOfDay = 86400.0;
  if (!(days >= 0.0 && days < kMostDays - (is_since_1904 ? kDaysTo1904 : 0.0))) return std::nullopt;
  const auto seconds = static_cast<std::int64_t>(std::round(days * kSecondsOfDay));
  const auto of_day = static_cast<int>(seconds % static_cast<int>(kSecondsOfDay));
  const auto clock = [of_day](std::int64_t hours) {
    return fmt::format("{:02}:{:02}:{:02}", hours, of_day / 60 % 60, of_day % 60);
  };
  if (format == NumberFormat::kTime) return clock(seconds / 3600);
  auto day = seconds / static_cast<std::int64_t>(kSecondsOfDay);
  constexpr std::int64_t kDayThatDidNotExist = 60;
  if (is_since_1904) {
    day += static_cast<std::int64_t>(kDaysTo1904);
  } else if (day < kDayThatDidNotExist) {
    ++day;
  }
  using std::chrono::sys_days;
  const std::chrono::year_month_day date(sys_days(std::chrono::year(1899) / 12 / 30) +
                                         std::chrono::days(day));
  const std::string text = fmt::format("{:04}-{:02}-{:02}",
                                       static_cast<int>(date.year()),
                                       static_cast<unsigned>(date.month()),
                                       static_cast<unsigned>(date.day()));
  return of_day == 0 ? text : text + "T" + clock(of_day / 3600);
}

}  // namespace silvafit::source
