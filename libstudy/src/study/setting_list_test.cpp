// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <set>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/study/setting_lists.hpp"
#include "silvafit/study/setting_names.hpp"
#include "study/settings_json.hpp"
#include "study/study_test_support.hpp"

using namespace silvafit;
using namespace silvafit::study;

namespace {

template <typename T>
std::string value_text(const data::Setting<T>& setting) {
  using Value = std::remove_const_t<T>;
  if (!setting.choices.empty()) return fmt::format("{}", fmt::join(setting.choices, ", "));
  if (!setting.type_name.empty()) return std::string(setting.type_name);
  if constexpr (std::same_as<Value, bool>) return "true or false";
  if constexpr (std::integral<Value>) return "whole number";
  if constexpr (std::floating_point<Value>) return "number";
  if constexpr (std::same_as<Value, std::string>) return "text";
  return "list";
}

/// The default value, if it is not none, 0 or false.
template <typename T>
std::string default_text(const data::Setting<const T>& setting) {
  nlohmann::ordered_json preset;
  if constexpr (data::HasWords<T>::value) {
    preset = data::word_of(setting);
  } else if constexpr (!std::same_as<T, std::optional<double>> &&
                       !std::same_as<T, std::map<std::string, fit::Bounds>>) {
    SettingsWriter writer;
    writer(setting);
    preset = writer.json().at(std::string(setting.key));
  }
  const bool is_none =
      preset.is_null() || preset == false || preset == 0.0 || preset.empty() || preset == "";
  return is_none ? "" : "`" + preset.dump() + "`";
}

/// The option of the program; some settings have none.
template <typename T>
std::string option_text(const data::Setting<T>& setting) {
  if (setting.key == "candidates") return "";
  if (!setting.option_name.empty()) return fmt::format("`--{}`", setting.option_name);
  std::string option = setting.key == "criteria" ? "criterion" : std::string(setting.key);
  std::ranges::replace(option, '_', '-');
  return fmt::format("`--{}`", option);
}

/// A list of settings on the page.
struct Section {
  std::string_view list{};
  std::string_view heading{};
  std::string_view commands{};  ///< of the program
  std::string_view r{};         ///< functions of R
  std::string_view python{};    ///< and of Python
  bool is_in_file = false;      ///< in study.json
};
constexpr std::string_view kInventories =
    "fit_study, structural_units, stand_summary, stand_growth";
constexpr std::string_view kOfPython = "study, structural_units, stand_summary, stand_growth";
constexpr auto kSections = std::to_array<Section>(
    {{"study", "Models of a study", "study", "fit_study", "study", true},
     {"reading",
      "Table of trees",
      "study, indices, stand, impute, tiles plan",
      "fit_study, structural_units, stand_summary, stand_growth, impute, "
      "predict.silvafit_library, grow_trees, view_stand",
      "study, structural_units, stand_summary, stand_growth, impute, Library.predict, grow, view",
      true},
     {"rows",
      "Rows of the table of trees",
      "study, indices, stand, fit, predict, impute, grow, view, columns",
      "fit_study",
      "study",
      true},
     {"units", "Structural units", "study, indices, stand", kInventories, kOfPython, true},
     {"sampling", "Sampled plots", "study, indices, stand", kInventories, kOfPython, true},
     {"stand",
      "Stand figures",
      "stand",
      "stand_summary, stand_growth",
      "stand_summary, stand_growth"},
     {"equations",
      "Volume, biomass and carbon",
      "stand, predict",
      "stand_summary, stand_growth, predict.silvafit_library",
      "stand_summary, stand_growth, Library.predict"},
     {"model", "Model", "fit", "silvafit", "fit"},
     {"fit", "Fit", "fit", "silvafit", "fit"},
     {"intervals", "Intervals", "fit", "confint.silvafit", "Fit.intervals"},
     {"bootstrap", "Bootstrap", "fit", "bootstrap", "Fit.bootstrap"},
     {"cross-validation", "Cross-validation", "fit", "cross_validate", "Fit.cross_validate"},
     {"predictions", "Predictions", "predict", "predict.silvafit_library", "Library.predict"},
     {"imputation", "Imputation", "impute", "impute", "impute"},
     {"grow", "Trees and scenes", "grow", "grow_trees", "grow"},
     {"view", "3D page", "view", "view_stand", "view"}});

/// All lists, with default values.
template <typename Visit>
void each_list(Visit&& visit) {
  each_setting_list([&visit](std::string_view name, const auto& settings) {
    visit(*std::ranges::find(kSections, name, &Section::list), settings);
  });
}

/// The names in a list, each in backquotes.
std::string in_backquotes(std::string_view names) {
  std::string text = "`";
  for (const char letter : names) text += letter == ',' ? "`," : std::string(1, letter);
  for (std::size_t at = 0; (at = text.find(", ", at)) != std::string::npos; at += 3) {
    text.insert(at + 2, "`");
  }
  return text + "`";
}

/// A help in a table.
std::string in_cell(std::string_view help) {
  std::string text;
  for (const char letter : help) text += letter == '|' ? "\\|" : std::string(1, letter);
  return text;
}

/// The tables of docs/settings.md.
class SettingTables {
 public:
  template <typename S>
  void operator()(const Section& section, const S& settings) {
    text_ += fmt::format(
        "\n## {}\n\n- program: {}\n- R: {}\n- Python: {}\n{}\n"
        "| setting | option | R | Python | value | default | meaning |\n"
        "|---|---|---|---|---|---|---|\n",
        section.heading,
        in_backquotes(section.commands),
        in_backquotes(section.r),
        in_backquotes(section.python),
        section.is_in_file ? "- file: `study.json`\n" : "");
    each_setting(settings, *this);
  }
  template <typename T>
  void operator()(const data::Setting<const T>& setting) {
    text_ += fmt::format("| `{0}` | {1} | `{2}` | `{0}` | {3} | {4} | {5} |\n",
                         setting.key,
                         option_text(setting),
                         argument_of_r(setting.key),
                         value_text(setting),
                         default_text(setting),
                         in_cell(setting.help));
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_{};
};

}  // namespace

TEST_CASE("the page of settings has every setting") {
  SettingTables tables;
  each_list(tables);
  const std::string page = read_file(test::source_file("docs/settings.md"));
  const std::string found = page.substr(std::min(page.find("\n## "), page.size()));
  if (found != tables.text()) std::ofstream("settings.md") << tables.text();
  INFO("settings.md in this folder has the tables that docs/settings.md should have");
  CHECK(found == tables.text());
}

TEST_CASE("settings of a list have different names and a sentence of help") {
  each_list([](const Section& /*section*/, const auto& settings) {
    std::set<std::string_view> keys;
    each_setting(settings, [&keys](const auto& setting) {
      CAPTURE(std::string(setting.key));
      CHECK(keys.insert(setting.key).second);
      CHECK_FALSE(setting.help.empty());
      CHECK(setting.help.back() != '.');
    });
  });
}

TEST_CASE("the words of a setting are those of its values") {
  const auto method_of = [](const std::string& word) {
    fit::FitModelOptions options;
    each_setting(options, [&word](const auto& setting) {
      if constexpr (data::HasWords<std::decay_t<decltype(setting.value)>>::value) {
        data::set_word(setting, word);
      }
    });
    return options.method;
  };
  for (const char* word : {"ols", "gnls", "lb", "foce", "focei", "laplace", "agq"}) {
    CHECK(method_of(word) == value_of<fit::Method>(word, "method"));
  }
  CHECK_FALSE(method_of(""));
  CHECK_THROWS_WITH(method_of("nlme"), Catch::Contains("'nlme' is not one of ols, gnls, lb"));
}

TEST_CASE("numbers of settings have ranges") {
  std::size_t folds = 0;
  double share = 0.0;
  const auto count = data::Setting("folds", folds, "help").or_word("leave-one-out").at_least(2);
  const auto level = data::Setting("level", share, "help").share();
  CHECK(data::wrong_number(count, 0.0, true).empty());
  CHECK(data::wrong_number(count, 1.0, true) == "1 is below 2");
  CHECK(data::wrong_number(count, 2.0, true).empty());
  const auto trees = data::Setting("trees", folds, "help").optional();
  CHECK(data::wrong_number(trees, 0.0, true).empty());
  CHECK(data::wrong_number(trees, -1.0, true) == "-1 is neither 0 nor at least 1");
  CHECK(data::wrong_number(level, 0.95).empty());
  CHECK_FALSE(data::wrong_number(level, 1.0).empty());
  CHECK_THROWS_WITH(data::require_number(level), Catch::Contains("must lie between 0 and 1"));
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
