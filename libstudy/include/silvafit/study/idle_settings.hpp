// SPDX-License-Identifier: MIT
// Settings that have no effect in a call: they are errors, for every front end.
#pragma once

#include <any>
#include <concepts>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

namespace silvafit::study {

/// The name of a setting as it was given, even if with the value that it has by default; empty if
/// it was not.
using GivenName = std::function<std::string(const data::SettingHead&)>;

/// By the key: the end of "has no effect ...", for what the settings themselves do not say, such as
/// "on growth".
using IdleReasons = std::map<std::string_view, std::string, std::less<>>;

/// Whether values of a setting differ. Maps are empty by default.
template <typename T>
bool settings_differ(const T& value, const T& other) {
  if constexpr (requires { typename T::mapped_type; }) {
    return value.size() != other.size();
  } else if constexpr (std::equality_comparable<T>) {
    return !(value == other);
  } else {
    return false;
  }
}

/// Refuses settings of a list that were given, or differ from their defaults, and have no effect:
/// by Setting::needs, or for one of the reasons. A name that is given twice would have none, too.
/// \throws UsageError that names the first one
template <typename Settings>
void refuse_idle_settings(const Settings& settings,
                          const GivenName& given_name = {},
                          const IdleReasons& reasons = {}) {
  std::map<std::string_view, std::any> defaults;
  const Settings initial{};
  each_setting(initial,
               [&defaults](const auto& setting) { defaults.emplace(setting.key, setting.value); });
  each_setting(settings, [&]<typename T>(const data::Setting<T>& setting) {
    if constexpr (std::same_as<std::remove_const_t<T>, std::vector<std::string>>) {
      if (setting.name_end != '\0') data::require_names_once(setting, setting.value);
    }
    const auto reason = reasons.find(setting.key);
    if (setting.lacks.empty() && reason == reasons.end()) return;
    const auto& initial_value =
        std::any_cast<const std::remove_const_t<T>&>(defaults.at(setting.key));
    std::string name = given_name ? given_name(setting) : "";
    if (name.empty() && !settings_differ(setting.value, initial_value)) return;
    if (name.empty()) name = "`" + std::string(setting.key) + "`";
    const std::string what =
        setting.lacks.empty() ? reason->second : "without " + std::string(setting.lacks);
    throw UsageError("has no effect " + what, {.column = std::move(name)});
  });
}

/// \throws UsageError that names a setting without effect on a fit
void refuse_idle(const fit::ModelTexts& texts,
                 const fit::FitModelOptions& options,
                 const GivenName& given_name = {});

}  // namespace silvafit::study
