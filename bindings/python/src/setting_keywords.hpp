// SPDX-License-Identifier: MIT
// Keyword arguments of Python as settings.
#pragma once

#include <concepts>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arguments.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::python {

/// Takes each setting from the keyword of its key.
class SettingKeywords {
 public:
  explicit SettingKeywords(Arguments& arguments) : arguments_(arguments) {}

  template <typename T>
  void operator()(const data::Setting<T>& setting) {
    if constexpr (data::HasWords<T>::value) {
      take_word(setting);
    } else if constexpr (std::is_arithmetic_v<T> && !std::same_as<T, bool>) {
      if (arguments_.take(setting.key.data(), setting.value)) data::require_number(setting);
    } else {
      if (!setting.choices.empty()) return take_word(setting);
      arguments_.take(setting.key.data(), setting.value);
    }
  }
  void operator()(const data::Setting<std::vector<std::string>>& setting) {
    if (setting.form != data::SettingForm::kMapping) {
      arguments_.take(setting.key.data(), setting.value);
      return;
    }
    std::map<std::string, std::string> sources;
    arguments_.take(setting.key.data(), sources);
    for (const auto& [name, source] : sources) setting.value.push_back(name + "=" + source);
  }
  /// Pairs of numbers, or None for an open end.
  void operator()(const data::Setting<std::map<std::string, fit::Bounds>>& setting) {
    std::map<std::string, std::pair<std::optional<double>, std::optional<double>>> bounds;
    arguments_.take(setting.key.data(), bounds);
    for (const auto& [name, ends] : bounds) {
      fit::Bounds& range = setting.value[name];
      range = {.low = ends.first.value_or(range.low), .high = ends.second.value_or(range.high)};
    }
  }

 private:
  template <typename T>
  void take_word(const data::Setting<T>& setting) {
    if constexpr (data::HasWords<T>::value || std::same_as<T, bool> ||
                  std::same_as<T, std::string>) {
      std::string word;
      arguments_.take(setting.key.data(), word);
      data::set_word(setting, word);
    }
  }

  Arguments& arguments_;
};

/// The settings of a list, from the keywords of their keys.
template <typename Settings>
Settings settings_of(Arguments& arguments, Settings settings = {}) {
  each_setting(settings, SettingKeywords(arguments));
  return settings;
}

}  // namespace silvafit::python
