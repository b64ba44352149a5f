// SPDX-License-Identifier: MIT
#include "study/settings_json.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "silvafit/base/error.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/setting_list.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;
using data::Setting;
using data::SettingForm;
using Json = SettingsWriter::Json;

Criterion criterion_of(const JsonReader& json) {
  try {
    return parse_criterion(json.text());
  } catch (const UsageError& error) {
    json.fail(error.what());
  }
}

/// Whether a setting changes what the indices of a tree mean; others choose trees or columns.
bool is_of_indices(std::string_view key) {
  constexpr std::array<std::string_view, 5> kOthers{
      "window", "circle", "edge", "buffer", "further"};
  return std::ranges::find(kOthers, key) == kOthers.end();
}

}  // namespace

void SettingsReader::read(const JsonReader& json, const Setting<bool>& setting) {
  setting.value = setting.choices.empty() ? json.boolean() : json.one_of(setting.choices) == 1;
}

void SettingsReader::read(const JsonReader& json, const Setting<double>& setting) {
  setting.value = setting.may_be_zero ? json.not_negative() : json.positive();
  if (setting.highest > 0.0) json.number_between(0.0, setting.highest);
}

void SettingsReader::read(const JsonReader& json, const Setting<std::size_t>& setting) {
  setting.value =
      setting.may_be_zero ? static_cast<std::size_t>(json.count_or_zero()) : json.count();
  if (setting.highest > 0.0) json.number_between(0.0, setting.highest);
}

void SettingsReader::read(const JsonReader& json, const Setting<std::string>& setting) const {
  const bool may_be_missing =
      setting.form == SettingForm::kText || setting.form == SettingForm::kFile;
  if (may_be_missing && json.is_null()) {
    setting.value.clear();
    return;
  }
  if (!setting.choices.empty()) json.one_of(setting.choices);
  setting.value =
      setting.form == SettingForm::kFile ? (folder_ / json.text()).string() : json.text();
}

void SettingsReader::read(const JsonReader& json,
                          const Setting<std::vector<std::string>>& setting) {
  if (setting.form != SettingForm::kMapping) {
    setting.value = json.texts();
    return;
  }
  setting.value.clear();
  for (const auto& [name, source] : json.members_by_name()) {
    setting.value.push_back(name + "=" + source.text());
  }
}

void SettingsReader::read(const JsonReader& json,
                          const Setting<std::map<std::string, std::vector<std::string>>>& setting) {
  for (const auto& [name, list] : json.members_by_name()) setting.value[name] = list.texts();
}

/// One criterion for all levels, or one for each level.
void SettingsReader::read(const JsonReader& json, const Setting<LevelCriteria>& setting) {
  LevelCriteria& criteria = setting.value;
  if (!json.is_object()) {
    const Criterion all = criterion_of(json);
    criteria = {.base = all, .covariates = all, .random = all, .variance = all};
    return;
  }
  json.allow_only({"base", "covariates", "random", "variance"});
  const auto read_level = [&](std::string_view key, Criterion& criterion) {
    if (const auto found = json.find(key)) criterion = criterion_of(*found);
  };
  read_level("base", criteria.base);
  read_level("covariates", criteria.covariates);
  read_level("random", criteria.random);
  read_level("variance", criteria.variance);
}

Json SettingsWriter::json_of(const Setting<const bool>& setting) {
  if (setting.choices.empty()) return setting.value;
  return setting.choices[setting.value ? 1 : 0];
}

Json SettingsWriter::json_of(const Setting<const std::string>& setting) {
  if (setting.form == SettingForm::kPlain) return setting.value;
  return text_or_null(setting.value);
}

Json SettingsWriter::json_of(const Setting<const std::vector<std::string>>& setting) {
  if (setting.form != SettingForm::kMapping) return setting.value;
  Json json = Json::object();
  const std::string entries = fmt::format("{}", fmt::join(setting.value, ","));
  for (const stand::ColumnMapping& column : stand::parse_column_mappings(entries)) {
    json[column.name] = column.source;
  }
  return json;
}

Json SettingsWriter::json_of(const Setting<const LevelCriteria>& setting) {
  const LevelCriteria& criteria = setting.value;
  return {{"base", criterion_text(criteria.base)},
          {"covariates", criterion_text(criteria.covariates)},
          {"random", criterion_text(criteria.random)},
          {"variance", criterion_text(criteria.variance)}};
}

Json settings_json(const StudyConfiguration& settings) {
  SettingsWriter writer;
  each_setting(settings, writer);
  return writer.json();
}

UnitSettings read_unit_settings(const JsonReader& json) {
  UnitSettings settings;
  each_setting(settings,
               SettingsReader(json, {}, [](std::string_view key) { return !is_of_indices(key); }));
  return settings;
}

Json unit_settings_json(const UnitSettings& settings) {
  SettingsWriter writer;
  each_setting(settings, [&writer](const auto& setting) {
    if (is_of_indices(setting.key)) writer(setting);
  });
  return writer.json();
}

}  // namespace silvafit::study
