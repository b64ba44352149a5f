// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <set>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/study/grow_setting_list.hpp"
#include "study/settings_json.hpp"
#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

std::string value_text(const data::Setting<const bool>&) { return "true or false"; }
std::string value_text(const data::Setting<const double>&) { return "number"; }
std::string value_text(const data::Setting<const std::size_t>&) { return "whole number"; }
std::string value_text(const data::Setting<const std::string>&) { return "text"; }
template <typename T>
std::string value_text(const data::Setting<T>&) {
  return std::is_enum_v<std::remove_const_t<T>> ? "word" : "list";
}

/// The tables of docs/settings.md.
class SettingTables {
 public:
  /// \param settings  with default values
  template <typename S>
  void add(std::string_view heading, const S& settings) {
    text_ += fmt::format("\n## {}\n\n| setting | value | default | meaning |\n|---|---|---|---|\n",
                         heading);
    each_setting(settings, *this);
  }
  template <typename T>
  void operator()(const data::Setting<const T>& setting) {
    std::string value(setting.type_name);
    if (!setting.choices.empty()) value = fmt::format("{}", fmt::join(setting.choices, ", "));
    if (value.empty()) value = value_text(setting);
    SettingsWriter writer;
    if constexpr (!std::is_enum_v<T>) writer(setting);
    const nlohmann::ordered_json preset =
        writer.json().value(std::string(setting.key), nlohmann::ordered_json());
    const bool has_default =
        !preset.is_null() && preset != false && preset != 0.0 && !preset.empty() && preset != "";
    text_ += fmt::format("| `{}` | {} | {} | {} |\n",
                         setting.key,
                         value,
                         has_default ? "`" + preset.dump() + "`" : "",
                         setting.help);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_{};
};

}  // namespace

TEST_CASE("the page of settings has every setting") {
  const StudyConfiguration settings;
  SettingTables tables;
  tables.add("Models", settings.study);
  tables.add("Table of trees", settings.reading);
  tables.add("Structural units", settings.units);
  tables.add("Sampled plots", settings.sampling);
  tables.add("Trees and scenes", GrowSettings{});
  const std::string page = read_file(test::source_file("docs/settings.md"));
  const std::string found = page.substr(std::min(page.find("\n## "), page.size()));
  if (found != tables.text()) std::ofstream("settings.md") << tables.text();
  INFO("settings.md in this folder has the tables that docs/settings.md should have");
  CHECK(found == tables.text());
}

TEST_CASE("settings have different names and a sentence of help") {
  std::set<std::string_view> keys;
  const auto check = [&keys](const auto& setting) {
    CAPTURE(std::string(setting.key));
    CHECK(keys.insert(setting.key).second);
    CHECK_FALSE(setting.help.empty());
    CHECK(setting.help.back() != '.');
  };
  const StudyConfiguration settings;
  each_setting(settings, check);
  keys.clear();
  const GrowSettings grown;
  each_setting(grown, check);
}

TEST_CASE("settings are the same after they were written and read") {
  StudyConfiguration settings;
  settings.study.species = {"A, B", "C"};
  settings.study.candidates["h"] = {"M4", "h ~ a*dbh^b"};
  settings.study.parsimonious = true;
  settings.study.needs_tests = false;
  settings.study.criteria.random = Criterion::kAicc;
  settings.reading.columns = {"dbh=DBH_cm", "h=h/100"};
  settings.units.open_grown = "0.9 + 0.22*dbh";
  settings.sampling.angle_count = 4.0;
  SettingsWriter writer;
  each_setting(std::as_const(settings), writer);
  const std::string text = writer.json().dump();
  StudyConfiguration read;
  SettingsReader reader(data::JsonReader::parse(text, "settings"), {});
  each_setting(read, reader);
  reader.finish();
  SettingsWriter again;
  each_setting(std::as_const(read), again);
  CHECK(again.json().dump() == text);
  CHECK(read.study.parsimonious);
  CHECK(read.sampling.angle_count == 4.0);
}
