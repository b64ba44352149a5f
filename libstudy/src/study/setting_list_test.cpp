// SPDX-License-Identifier: MIT
#include "silvafit/fit/setting_list.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>
#include <set>

#include "reference.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/grow_setting_list.hpp"
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
  if (!setting.option_name.empty()) return fmt::format("`{}`", setting.option_name);
  std::string option = setting.key == "criteria" ? "criterion" : std::string(setting.key);
  std::ranges::replace(option, '_', '-');
  return fmt::format("`--{}`", option);
}

/// A list of settings on the page.
struct Section {
  std::string_view heading{};
  std::string_view commands{};  ///< of the program
  std::string_view r{};         ///< functions of R
  std::string_view python{};    ///< and of Python
  bool is_in_file = false;      ///< in study.json
};

/// All lists, with default values.
template <typename Visit>
void each_list(Visit&& visit) {
  const StudyConfiguration study;
  const std::string_view inventories = "fit_study, structural_units, stand_summary, stand_growth";
  const std::string_view of_python = "study, structural_units, stand_summary, stand_growth";
  visit(Section{.heading = "Models of a study",
                .commands = "study",
                .r = "fit_study",
                .python = "study",
                .is_in_file = true},
        study.study);
  visit(Section{.heading = "Table of trees",
                .commands = "study, indices, stand, impute, tiles plan",
                .r = "fit_study, structural_units, stand_summary, stand_growth, impute, "
                     "predict.silvafit_library, grow_trees, view_stand",
                .python = "study, structural_units, stand_summary, stand_growth, impute, "
                          "Library.predict, grow, view",
                .is_in_file = true},
        study.reading);
  visit(Section{.heading = "Rows of the table of trees",
                .commands = "study, indices, stand, fit, predict, impute, grow, view, columns",
                .r = "fit_study",
                .python = "study",
                .is_in_file = true},
        study.reading.rows);
  visit(Section{.heading = "Structural units",
                .commands = "study, indices, stand",
                .r = inventories,
                .python = of_python,
                .is_in_file = true},
        study.units);
  visit(Section{.heading = "Sampled plots",
                .commands = "study, indices, stand",
                .r = inventories,
                .python = of_python,
                .is_in_file = true},
        study.sampling);
  visit(Section{.heading = "Stand figures",
                .commands = "stand",
                .r = "stand_summary, stand_growth",
                .python = "stand_summary, stand_growth"},
        StandOptions());
  visit(Section{.heading = "Volume, biomass and carbon",
                .commands = "stand, predict",
                .r = "stand_summary, stand_growth, predict.silvafit_library",
                .python = "stand_summary, stand_growth, Library.predict"},
        EquationSettings());
  visit(Section{.heading = "Model", .commands = "fit", .r = "silvafit", .python = "fit"},
        fit::ModelTexts());
  visit(Section{.heading = "Fit", .commands = "fit", .r = "silvafit", .python = "fit"},
        fit::FitModelOptions());
  visit(Section{.heading = "Intervals",
                .commands = "fit",
                .r = "confint.silvafit",
                .python = "Fit.intervals"},
        fit::IntervalOptions());
  visit(
      Section{
          .heading = "Bootstrap", .commands = "fit", .r = "bootstrap", .python = "Fit.bootstrap"},
      fit::BootstrapOptions());
  visit(Section{.heading = "Cross-validation",
                .commands = "fit",
                .r = "cross_validate",
                .python = "Fit.cross_validate"},
        fit::CrossValidationOptions());
  visit(Section{.heading = "Predictions",
                .commands = "predict",
                .r = "predict.silvafit_library",
                .python = "Library.predict"},
        PredictionSettings());
  visit(Section{.heading = "Imputation", .commands = "impute", .r = "impute", .python = "impute"},
        ImputeOptions());
  visit(
      Section{
          .heading = "Trees and scenes", .commands = "grow", .r = "grow_trees", .python = "grow"},
      GrowSettings());
  visit(Section{.heading = "3D page", .commands = "view", .r = "view_stand", .python = "view"},
        ViewOptions());
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
    CHECK(method_of(word) == fit::parse_method(word));
  }
  CHECK_FALSE(method_of(""));
  CHECK_THROWS_WITH(method_of("nlme"), Catch::Contains("'nlme' is not one of ols, gnls, lb"));
  tree::BuilderKind builder{};
  fit::Resample resample{};
  fit::IntervalMethod intervals{};
  const auto words = [](auto& value, std::vector<std::string_view> all, auto name_of) {
    for (const std::string_view word : all) {
      data::set_word(data::Setting("key", value, "help").one_of(all), std::string(word));
      CHECK(name_of(value) == word);
    }
  };
  words(builder, {"segment", "lsystem", "ifs", "bamboo"}, tree::builder_name);
  words(resample, {"parametric", "cases"}, fit::resample_text);
  words(intervals, {"wald", "profile"}, [](fit::IntervalMethod method) {
    return method == fit::parse_interval_method("wald") ? "wald" : "profile";
  });
}

TEST_CASE("numbers of settings have ranges") {
  std::size_t folds = 0;
  double share = 0.0;
  const auto count = data::Setting("folds", folds, "help").or_word("leave-one-out").at_least(2);
  const auto level = data::Setting("level", share, "help").share();
  CHECK(data::wrong_number(count, 0.0, true).empty());
  CHECK(data::wrong_number(count, 1.0, true) == "1 is below 2");
  CHECK(data::wrong_number(count, 2.0, true).empty());
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
