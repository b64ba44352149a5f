// SPDX-License-Identifier: MIT
#include "study/unit_settings_json.hpp"

#include <algorithm>
#include <array>

#include "silvafit/study/setting_list.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {
namespace {

/// Whether a setting changes what the indices of a tree mean; others choose trees or columns.
bool is_of_indices(std::string_view key) {
  constexpr std::array<std::string_view, 5> kOthers{
      "window", "circle", "edge", "buffer", "further"};
  return std::ranges::find(kOthers, key) == kOthers.end();
}

}  // namespace

UnitSettings read_unit_settings(const data::JsonReader& json) {
  UnitSettings settings;
  each_setting(settings,
               SettingsReader(json, {}, [](std::string_view key) { return !is_of_indices(key); }));
  return settings;
}

nlohmann::ordered_json unit_settings_json(const UnitSettings& settings) {
  SettingsWriter writer;
  each_setting(settings, [&writer](const auto& setting) {
    if (is_of_indices(setting.key)) writer(setting);
  });
  return writer.json();
}

}  // namespace silvafit::study
