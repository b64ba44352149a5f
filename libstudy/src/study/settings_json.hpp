// SPDX-License-Identifier: MIT
// Settings as JSON, with the keys of study.json: visitors that read and write them.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/data/setting.hpp"
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

  template <typename T>
  void operator()(const data::Setting<T>& setting) {
    keys_.push_back(setting.key);
    if (is_given_ && is_given_(setting.key)) return;
    if (const auto json = json_.find(setting.key)) read(*json, setting);
  }
  /// Refuses keys that no setting has.
  void finish() const { json_.allow_only(keys_); }

 private:
  static void read(const data::JsonReader& json, const data::Setting<bool>& setting);
  static void read(const data::JsonReader& json, const data::Setting<double>& setting);
  static void read(const data::JsonReader& json, const data::Setting<std::size_t>& setting);
  void read(const data::JsonReader& json, const data::Setting<std::string>& setting) const;
  static void read(const data::JsonReader& json,
                   const data::Setting<std::vector<std::string>>& setting);
  static void read(const data::JsonReader& json,
                   const data::Setting<std::map<std::string, std::vector<std::string>>>& setting);
  static void read(const data::JsonReader& json, const data::Setting<LevelCriteria>& setting);

  data::JsonReader json_;
  std::filesystem::path folder_;
  std::function<bool(std::string_view)> is_given_;
  std::vector<std::string_view> keys_{};
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
    return setting.value;
  }
  static Json json_of(const data::Setting<const bool>& setting);
  static Json json_of(const data::Setting<const std::string>& setting);
  static Json json_of(const data::Setting<const std::vector<std::string>>& setting);
  static Json json_of(const data::Setting<const LevelCriteria>& setting);

  Json json_ = Json::object();
};

/// Every key of study.json with its value.
nlohmann::ordered_json settings_json(const StudyConfiguration& settings);

/// Reads the keys of the search and of the indices, if present; other keys are ignored.
/// \throws InputError that names file and key where a value cannot be used
UnitSettings read_unit_settings(const data::JsonReader& json);

/// These keys with their values.
nlohmann::ordered_json unit_settings_json(const UnitSettings& settings);

}  // namespace silvafit::study
