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

/// Whether a setting changes what the indices of a tree mean; others choose trees or columns.
bool is_of_indices(std::string_view key) {
  constexpr std::array<std::string_view, 5> kOthers{
      "window", "circle", "edge", "buffer", "further"};
  return std::ranges::find(kOthers, key) == kOthers.end();
}

/// Whether entries are written as name=value, which an object has, too.
bool has_names(const data::SettingHead& setting) {
  return setting.form == SettingForm::kMapping ||
         setting.type_name.find('=') != std::string_view::npos;
}

/// A list that is not empty by default needs a number.
template <typename Number>
void refuse_none(const JsonReader& json,
                 const std::vector<JsonReader>& items,
                 const std::vector<Number>& preset) {
  if (items.empty() && !preset.empty()) json.fail("must have a number");
}

}  // namespace

std::optional<JsonReader> SettingsReader::find(std::string_view key) const {
  auto json = json_.find(key);
  if (json && is_call_ && json->is_null()) return std::nullopt;
  return json;
}

std::string SettingsReader::word(const JsonReader& json, const data::SettingHead& setting) const {
  if (is_call_ && json.any_text().empty()) return {};
  return std::string(setting.choices[json.one_of(setting.choices)]);
}

double SettingsReader::number(const JsonReader& json,
                              const data::SettingHead& setting,
                              bool is_whole,
                              double largest) {
  const double value = json.number();
  std::string wrong = data::wrong_number(setting, value, is_whole);
  const bool is_count = value == std::floor(value) && value <= std::min(largest, 0x1p53);
  if (wrong.empty() && is_whole && !is_count) wrong = fmt::format("{} is no whole number", value);
  if (!wrong.empty()) json.fail(wrong);
  return value;
}

std::vector<JsonReader> SettingsReader::items(const JsonReader& json) const {
  return is_call_ && !json.is_list() ? std::vector{json} : json.items();
}

std::string SettingsReader::text(const JsonReader& json, bool may_be_number) const {
  if (!is_call_) return json.text();
  return may_be_number ? json.label() : json.any_text();
}

std::vector<std::string> SettingsReader::texts(const JsonReader& json, bool may_be_numbers) const {
  std::vector<std::string> result;
  for (const JsonReader& item : items(json)) result.push_back(text(item, may_be_numbers));
  return result;
}

void SettingsReader::read(const JsonReader& json, const Setting<bool>& setting) const {
  if (setting.choices.empty()) {
    setting.value = json.boolean();
  } else {
    data::set_word(setting, word(json, setting));
  }
}

void SettingsReader::read(const JsonReader& json,
                          const Setting<std::optional<double>>& setting) const {
  setting.value = json.number();
}

void SettingsReader::read(const JsonReader& json, const Setting<std::string>& setting) const {
  const bool may_be_missing =
      setting.form == SettingForm::kText || setting.form == SettingForm::kFile;
  if (may_be_missing && json.is_null()) {
    setting.value.clear();
  } else if (!setting.choices.empty()) {
    data::set_word(setting, word(json, setting));
  } else {
    const std::string value = is_call_ ? json.any_text() : json.text();
    const bool is_file = setting.form == SettingForm::kFile && !value.empty();
    setting.value = is_file ? (folder_ / value).string() : value;
  }
}

void SettingsReader::read(const JsonReader& json,
                          const Setting<std::vector<std::string>>& setting) const {
  const bool is_strict = setting.form == SettingForm::kMapping && !is_call_;
  if (!has_names(setting) || !(json.is_object() || is_strict)) {
    const bool has_labels = setting.form == SettingForm::kNames || setting.type_name == "CODE,...";
    setting.value = texts(json, has_labels || has_names(setting));
    return;
  }
  setting.value.clear();
  for (const auto& [name, source] : is_call_ ? json.members() : json.members_by_name()) {
    setting.value.push_back(name.empty() ? text(source, true) : name + "=" + text(source, true));
  }
}

void SettingsReader::read(const JsonReader& json, const Setting<std::vector<int>>& setting) const {
  refuse_none(json, items(json), setting.value);
  setting.value.clear();
  constexpr double kLargest = std::numeric_limits<int>::max();
  const data::SettingHead whole{.key = setting.key, .help = setting.help, .may_be_zero = true};
  for (const JsonReader& item : items(json)) {
    setting.value.push_back(static_cast<int>(number(item, whole, true, kLargest)));
  }
}

void SettingsReader::read(const JsonReader& json,
                          const Setting<std::vector<double>>& setting) const {
  refuse_none(json, items(json), setting.value);
  setting.value.clear();
  for (const JsonReader& item : items(json)) setting.value.push_back(item.number());
}

void SettingsReader::read(
    const JsonReader& json,
    const Setting<std::map<std::string, std::vector<std::string>>>& setting) const {
  for (const auto& [name, list] : json.members_by_name()) setting.value[name] = texts(list, false);
}

void SettingsReader::read(const JsonReader& json,
                          const Setting<std::map<std::string, double>>& setting) const {
  setting.value = json.numbers_by_name();
}

/// Pairs of numbers; null is an open end.
void SettingsReader::read(const JsonReader& json,
                          const Setting<std::map<std::string, fit::Bounds>>& setting) const {
  for (const auto& [name, range] : json.members_by_name()) {
    const std::vector<JsonReader> ends = range.items();
    if (ends.size() != 2) range.fail("must have two ends, such as [0, null]");
    fit::Bounds& bounds = setting.value[name];
    if (!ends[0].is_null()) bounds.low = ends[0].number();
    if (!ends[1].is_null()) bounds.high = ends[1].number();
  }
}

/// One criterion for all levels, or one for each level.
void SettingsReader::read(const JsonReader& json, const Setting<LevelCriteria>& setting) const {
  LevelCriteria& criteria = setting.value;
  if (!json.is_object()) {
    const Criterion all = json.word<Criterion>();
    criteria = {.base = all, .covariates = all, .random = all, .variance = all};
    return;
  }
  json.allow_only({"base", "covariates", "random", "variance"});
  const auto read_level = [&](std::string_view key, Criterion& criterion) {
    if (const auto found = json.find(key)) criterion = found->word<Criterion>();
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
  return {{"base", word_of(criteria.base)},
          {"covariates", word_of(criteria.covariates)},
          {"random", word_of(criteria.random)},
          {"variance", word_of(criteria.variance)}};
}

UnitSettings read_unit_settings(const JsonReader& json) {
  UnitSettings settings;
  each_setting(settings, SettingsReader(json, {}, [](std::string_view key) {
                 return !is_of_indices(key) && key != "edge";
               }));
  return settings;
}

Json unit_settings_json(const UnitSettings& settings) {
  SettingsWriter writer;
  // On a torus trees have other neighbors; the other edge corrections choose among trees.
  const bool is_torus = settings.edge == stand::EdgeCorrection::kTorus;
  each_setting(settings, [&writer, is_torus](const auto& setting) {
    if (is_of_indices(setting.key) || (is_torus && setting.key == "edge")) writer(setting);
  });
  return writer.json();
}

}  // namespace silvafit::study
