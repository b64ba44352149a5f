// SPDX-License-Identifier: MIT
// A setting, described once: the program, JSON files, R, Python and the documentation read it here.
#pragma once

#include <string_view>
#include <vector>

namespace silvafit::data {

/// What the value of a setting is, besides its type.
enum class SettingForm {
  kPlain,
  kText,     ///< a text that may be missing: null in JSON
  kFile,     ///< the same, a path relative to the JSON file
  kMapping,  ///< texts `name=source`: an object in JSON
  kNames,    ///< names that may contain commas
};

/// A value with its name and description. A list of settings is a function that visits each:
///
///     template <typename Visit>
///     void each_setting(UnitSettings& settings, Visit&& visit) {
///       visit(Setting("buffer", settings.buffer_m, "Width of the buffer in m").optional());
///     }
///
/// \tparam T  bool, a number, std::string, a vector of texts, or a type for which each visitor has
///            an overload; const for visitors that write
template <typename T>
struct Setting {
  Setting(std::string_view own_key, T& own_value, std::string_view own_help)
      : key(own_key), value(own_value), help(own_help) {}

  /// What stands for the value in usage lines, such as COLUMN.
  Setting& type(std::string_view name) {
    type_name = name;
    return *this;
  }
  Setting& as(SettingForm own_form, std::string_view name) {
    form = own_form;
    type_name = name;
    return *this;
  }
  /// The words that are allowed; of a bool the words of false and true.
  Setting& one_of(std::vector<std::string_view> words) {
    choices = std::move(words);
    return *this;
  }
  /// The option of the program, if it is not that of the key; of a bool that is true by default,
  /// the flag that makes it false.
  Setting& option(std::string_view name) {
    option_name = name;
    return *this;
  }
  /// A number that may be 0, which then means that it is not given.
  Setting& optional() {
    may_be_zero = true;
    return *this;
  }
  Setting& at_most(double limit) {
    highest = limit;
    return *this;
  }

  std::string_view key;  ///< as in JSON, R and Python; the option is the same with hyphens
  T& value;
  std::string_view help;  ///< a sentence without a period
  std::string_view type_name{};
  std::string_view option_name{};
  SettingForm form = SettingForm::kPlain;
  std::vector<std::string_view> choices{};
  bool may_be_zero = false;
  double highest = 0.0;  ///< of a number; 0: no limit
};

}  // namespace silvafit::data
