// SPDX-License-Identifier: MIT
#include "silvafit/data/setting.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::data {

std::string wrong_number(const SettingHead& setting, double value, bool is_whole) {
  if (setting.is_share) {
    return value > 0.0 && value < 1.0 ? "" : "must lie between 0 and 1, such as 0.95";
  }
  if (setting.may_be_zero && value == 0.0) return {};
  const double least = std::max(setting.lowest, is_whole ? 1.0 : 0.0);
  const bool is_above = least > 0.0 ? value >= least : value > 0.0;
  const bool is_below = setting.highest == 0.0 || value <= setting.highest;
  if (is_above && is_below) return {};
  if (setting.highest > 0.0)
    return fmt::format("{} is not between {} and {}", value, least, setting.highest);
  if (setting.may_be_zero && setting.zero_word.empty() && least > 0.0) {
    return fmt::format("{} is neither 0 nor at least {}", value, least);
  }
  const bool is_at_least = least > 0.0 || setting.may_be_zero;
  return fmt::format("{} is {} {}", value, is_at_least ? "below" : "not above", least);
}

void refuse(const SettingHead& setting, const std::string& problem) {
  throw UsageError(problem, {.column = fmt::format("`{}`", setting.key)});
}

void require_names_once(const SettingHead& setting, const std::vector<std::string>& entries) {
  std::set<std::string> names;
  for (const std::string& entry : entries) {
    const std::size_t end = entry.find(setting.name_end);
    const std::string name(trimmed(entry.substr(0, end == std::string::npos ? 0 : end)));
    if (names.insert(name).second) continue;
    refuse(
        setting,
        name.empty() ? "two values are for all names" : fmt::format("'{}' is given twice", name));
  }
}

std::size_t choice_of(const SettingHead& setting, std::string_view word) {
  const auto found = std::ranges::find(setting.choices, word);
  if (found == setting.choices.end()) {
    refuse(setting, fmt::format("'{}' is not one of {}", word, fmt::join(setting.choices, ", ")));
  }
  return static_cast<std::size_t>(found - setting.choices.begin());
}

}  // namespace silvafit::data
