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
  /// One criterion for all levels, or one for each of base, covariates, random, variance.
  void operator()(const data::Setting<study::LevelCriteria>& setting) const {
    std::vector<std::string> words;
    arguments_.read(setting.key.data(), words);
    if (words.empty()) return;
    if (words.size() == 1) words.resize(4, words.front());
    if (words.size() != 4) {
      throw UsageError("has one criterion, or four: base, covariates, random, variance",
                       {.column = std::string(setting.key)});
    }
    setting.value = {.base = study::parse_criterion(words[0]),
                     .covariates = study::parse_criterion(words[1]),
                     .random = study::parse_criterion(words[2]),
                     .variance = study::parse_criterion(words[3])};
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
