// SPDX-License-Identifier: MIT
// Settings as JSON, with the keys of study.json: visitors that read and write them.
#pragma once

#include <cmath>
#include <concepts>
#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/study.hpp"
#include "silvafit/study/study_configuration.hpp"

namespace silvafit::study {

/// Reads the settings that are present; others keep their values.
/// \throws InputError that names file and key where a value cannot be used
class SettingsReader {
 public:
  /// \param folder    of the paths
  /// \param is_given  settings that are not read, by their keys; empty: all are read
  SettingsReader(data::JsonReader json,
                 std::filesystem::path folder,
                 std::function<bool(std::string_view)> is_given = {})
      : json_(std::move(json)), folder_(std::move(folder)), is_given_(std::move(is_given)) {}
  /// Of the arguments of a call in R or Python: one value may stand for a list and a number for a
  /// label or code, null is an argument that is not given, and a text may be empty.
  static SettingsReader of_call(data::JsonReader json) {
    SettingsReader reader(std::move(json), {});
    reader.is_call_ = true;
    return reader;
  }

  template <typename T>
  void operator()(const data::Setting<T>& setting) {
    keys_.emplace_back(setting.key);
    if (is_given_ && is_given_(setting.key)) return;
    const auto json = find(setting.key);
    if (!json) return;
    if constexpr (data::HasWords<T>::value) {
      data::set_word(setting, word(*json, setting));
    } else if constexpr (std::is_arithmetic_v<T> && !std::same_as<T, bool>) {
      setting.value = static_cast<T>(number(
          *json, setting, std::integral<T>, static_cast<double>(std::numeric_limits<T>::max())));
    } else {
      read(*json, setting);
    }
  }
  /// The value of a key that is no setting; none if it is absent, or null in a call.
  std::optional<data::JsonReader> find(std::string_view key) const;
  /// Refuses keys that no setting has.
  void finish() const { json_.allow_only({keys_.begin(), keys_.end()}); }
  /// The keys of the settings that were looked for.
  const std::vector<std::string>& keys() const { return keys_; }

 private:
  using Json = data::JsonReader;

  std::string word(const Json& json, const data::SettingHead& setting) const;
  static double number(const Json& json,
                       const data::SettingHead& setting,
                       bool is_whole,
                       double largest);
  std::vector<Json> items(const Json& json) const;
  std::string text(const Json& json, bool may_be_number) const;
  std::vector<std::string> texts(const Json& json, bool may_be_numbers) const;
  void read(const Json& json, const data::Setting<bool>& setting) const;
  void read(const Json& json, const data::Setting<std::optional<double>>& setting) const;
  void read(const Json& json, const data::Setting<std::string>& setting) const;
  void read(const Json& json, const data::Setting<std::vector<std::string>>& setting) const;
  void read(const Json& json, const data::Setting<std::vector<int>>& setting) const;
  void read(const Json& json, const data::Setting<std::vector<double>>& setting) const;
  void read(const Json& json,
            const data::Setting<std::map<std::string, std::vector<std::string>>>& setting) const;
  void read(const Json& json, const data::Setting<std::map<std::string, double>>& setting) const;
  void read(const Json& json,
            const data::Setting<std::map<std::string, fit::Bounds>>& setting) const;
  void read(const Json& json, const data::Setting<LevelCriteria>& setting) const;

  Json json_;
  std::filesystem::path folder_;
  std::function<bool(std::string_view)> is_given_;
  bool is_call_ = false;
  std::vector<std::string> keys_{};
};

/// Collects settings as an object, in their order.
class SettingsWriter {
 public:
  using Json = nlohmann::ordered_json;

  template <typename T>
  void operator()(const data::Setting<const T>& setting) {
    json_[std::string(setting.key)] = json_of(setting);
  }
  const Json& json() const { return json_; }

 private:
  template <typename T>
  static Json json_of(const data::Setting<const T>& setting) {
    if constexpr (data::HasWords<T>::value) {
      return data::word_of(setting);
    } else {
      return setting.value;
    }
  }
  static Json json_of(const data::Setting<const bool>& setting);
  static Json json_of(const data::Setting<const std::string>& setting);
  static Json json_of(const data::Setting<const std::vector<std::string>>& setting);
  static Json json_of(const data::Setting<const LevelCriteria>& setting);

  Json json_ = Json::object();
};

/// Every key of a list with its value.
template <typename Settings>
nlohmann::ordered_json settings_json(const Settings& settings) {
  SettingsWriter writer;
  each_setting(settings, writer);
  return writer.json();
}

/// Reads the keys of the search and of the indices, if present; other keys are ignored.
/// \throws InputError that names file and key where a value cannot be used
UnitSettings read_unit_settings(const data::JsonReader& json);

/// These keys with their values.
nlohmann::ordered_json unit_settings_json(const UnitSettings& settings);

}  // namespace silvafit::study
