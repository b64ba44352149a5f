// SPDX-License-Identifier: MIT
// Arguments of R as settings.
#pragma once

#include <cmath>
#include <concepts>
#include <cpp11/list.hpp>
#include <map>
#include <string>
#include <type_traits>
#include <vector>

#include "conversion.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/study.hpp"

namespace silvafit::r {

/// Reads each setting from the argument of its key; tables of plots are data frames.
class SettingArguments {
 public:
  explicit SettingArguments(const Arguments& arguments) : arguments_(arguments) {}

  template <typename T>
  void operator()(const data::Setting<T>& setting) const {
    const char* const key = setting.key.data();
    if constexpr (data::HasWords<T>::value) {
      read_word(setting);
    } else if constexpr (std::is_arithmetic_v<T> && !std::same_as<T, bool>) {
      if (!arguments_.has(key)) return;
      arguments_.read(key, setting.value);
      data::require_number(setting);
    } else {
      const bool is_table = setting.key == "plots" && setting.form == data::SettingForm::kFile;
      if (!setting.choices.empty()) return read_word(setting);
      if (!is_table) arguments_.read(key, setting.value);
    }
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
      if (number != std::floor(number)) data::refuse(setting, "has a number that is not whole");
      setting.value.push_back(static_cast<int>(number));
    }
  }
  void operator()(const data::Setting<std::vector<double>>& setting) const {
    if (arguments_.has(setting.key.data())) {
      setting.value = numbers_of(arguments_[setting.key.data()]);
    }
  }
  /// A named vector of numbers.
  void operator()(const data::Setting<std::map<std::string, double>>& setting) const {
    if (arguments_.has(setting.key.data())) {
      setting.value = named_numbers(arguments_[setting.key.data()]);
    }
  }
  /// Named vectors of the arguments `lower` and `upper`.
  void operator()(const data::Setting<std::map<std::string, fit::Bounds>>& setting) const {
    const auto read = [this, &setting](const char* argument, double fit::Bounds::*end) {
      if (!arguments_.has(argument)) return;
      for (const auto& [name, value] : named_numbers(arguments_[argument])) {
        setting.value[name].*end = value;
      }
    };
    read("lower", &fit::Bounds::low);
    read("upper", &fit::Bounds::high);
  }

 private:
  template <typename T>
  void read_word(const data::Setting<T>& setting) const {
    if constexpr (data::HasWords<T>::value || std::same_as<T, bool> ||
                  std::same_as<T, std::string>) {
      std::string word;
      arguments_.read(setting.key.data(), word);
      data::set_word(setting, word);
    }
  }

  const Arguments& arguments_;
};

}  // namespace silvafit::r
