// SPDX-License-Identifier: MIT
// Arguments of R as settings.
#pragma once

#include <algorithm>
#include <cmath>
#include <cpp11/list.hpp>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "conversion.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/study/study.hpp"
#include "silvafit/tree/builder.hpp"

namespace silvafit::r {

/// Reads each setting from the argument of its key; tables of plots are data frames.
class SettingArguments {
 public:
  explicit SettingArguments(const Arguments& arguments) : arguments_(arguments) {}

  template <typename T>
  void operator()(const data::Setting<T>& setting) const {
    const bool is_table = setting.key == "plots" && setting.form == data::SettingForm::kFile;
    if (!is_table) arguments_.read(setting.key.data(), setting.value);
  }
  void operator()(const data::Setting<bool>& setting) const {
    if (setting.choices.empty()) return arguments_.read(setting.key.data(), setting.value);
    std::string word(setting.choices[setting.value ? 1 : 0]);
    arguments_.read(setting.key.data(), word);
    const auto found = std::ranges::find(setting.choices, word);
    if (found == setting.choices.end()) {
      std::string words;
      for (const std::string_view choice : setting.choices) {
        words += (words.empty() ? "" : ", ") + std::string(choice);
      }
      throw UsageError("'" + word + "' is not one of " + words,
                       {.column = std::string(setting.key)});
    }
    setting.value = found != setting.choices.begin();
  }
  /// A named list of texts.
  void operator()(
      const data::Setting<std::map<std::string, std::vector<std::string>>>& setting) const {
    const char* const key = setting.key.data();
    if (!arguments_.has(key)) return;
    const cpp11::list list(arguments_[key]);
    const std::vector<std::string> names = texts_of(Rf_getAttrib(arguments_[key], R_NamesSymbol));
    for (std::size_t i = 0; i < names.size(); ++i) {
      setting.value[names[i]] = texts_of(list[static_cast<R_xlen_t>(i)]);
    }
  }
  /// One criterion for all levels, or those of named levels: base, covariates, random, variance.
  void operator()(const data::Setting<study::LevelCriteria>& setting) const {
    std::vector<std::string> words;
    arguments_.read(setting.key.data(), words);
    if (words.empty()) return;
    study::LevelCriteria& levels = setting.value;
    const std::map<std::string, study::Criterion*> by_name{{"base", &levels.base},
                                                           {"covariates", &levels.covariates},
                                                           {"random", &levels.random},
                                                           {"variance", &levels.variance}};
    SEXP names = Rf_getAttrib(arguments_[setting.key.data()], R_NamesSymbol);
    if (names == R_NilValue && words.size() == 1) {
      for (const auto& [name, level] : by_name) *level = study::parse_criterion(words.front());
      return;
    }
    const std::vector<std::string> given =
        names == R_NilValue ? std::vector<std::string>(words.size()) : texts_of(names);
    for (std::size_t i = 0; i < words.size(); ++i) {
      const auto level = by_name.find(given[i]);
      if (level == by_name.end()) {
        throw UsageError("has one criterion, or named ones: base, covariates, random, variance",
                         {.column = std::string(setting.key)});
      }
      *level->second = study::parse_criterion(words[i]);
    }
  }
  void operator()(const data::Setting<std::vector<int>>& setting) const {
    if (!arguments_.has(setting.key.data())) return;
    setting.value.clear();
    for (const double number : numbers_of(arguments_[setting.key.data()])) {
      if (number != std::floor(number)) {
        throw UsageError("has a number that is not whole", {.column = std::string(setting.key)});
      }
      setting.value.push_back(static_cast<int>(number));
    }
  }
  void operator()(const data::Setting<tree::BuilderKind>& setting) const {
    std::string name;
    arguments_.read(setting.key.data(), name);
    if (!name.empty()) setting.value = tree::builder_from_text(name);
  }

 private:
  const Arguments& arguments_;
};

}  // namespace silvafit::r
