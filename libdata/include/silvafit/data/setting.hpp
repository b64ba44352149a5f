// SPDX-License-Identifier: MIT
// A setting, described once: the program, JSON files, R, Python and the documentation read it here.
#pragma once

#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "silvafit/base/enum_words.hpp"

namespace silvafit::data {

/// What the value of a setting is, besides its type.
enum class SettingForm {
  kPlain,
  kText,        ///< a text that may be missing: null in JSON
  kFile,        ///< the same, a path relative to the JSON file
  kMapping,     ///< texts `name=source`: an object in JSON
  kNames,       ///< names that may contain commas
  kRepeatable,  ///< texts that may contain commas, each with an option of its own
};

/// The description of a setting, without its value.
struct SettingHead {
  std::string_view key;   ///< as in JSON, R and Python; the option is the same with hyphens
  std::string_view help;  ///< a sentence without a period
  std::string_view type_name{};
  std::string_view option_name{};
  SettingForm form = SettingForm::kPlain;
  std::vector<std::string_view> choices{};
  std::string_view zero_word{};
  bool may_be_zero = false;
  bool is_share = false;
  char name_end = '\0';  ///< of entries `name=value`, whose names must differ; 0: they may recur
  double lowest = 0.0;   ///< of a number; 0: none, except that of may_be_zero
  double highest = 0.0;  ///< 0: no limit
  /// Without this the setting has no effect, by the values of the other settings; empty: it has
  /// one.
  std::string_view lacks{};
};

/// The type of a setting's value, without const and std::optional.
template <typename T>
struct ValueType {
  using type = std::remove_const_t<T>;
};
template <typename T>
struct ValueType<std::optional<T>> : ValueType<T> {};
template <typename T>
struct ValueType<const std::optional<T>> : ValueType<T> {};
template <typename T>
using ValueOf = typename ValueType<T>::type;

/// A value with its name and description. A list of settings is a function that visits each:
///
///     template <typename Visit>
///     void each_setting(UnitSettings& settings, Visit&& visit) {
///       visit(Setting("buffer", settings.buffer_m, "Width of the buffer in m").optional());
///     }
///
/// \tparam T  bool, a number, std::string, a vector of texts, an enumeration or std::optional of it
///            whose values have the order of the words, or a type for which each visitor has an
///            overload; const for visitors that write
template <typename T>
struct Setting : SettingHead {
  Setting(std::string_view own_key, T& own_value, std::string_view own_help)
      : SettingHead{.key = own_key, .help = own_help}, value(own_value) {
    if constexpr (Worded<ValueOf<T>>) {
      const auto words = words_of(ValueOf<T>{});
      choices.assign(words.begin(), words.end());
    }
  }

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
  /// The words of a bool, those of false and true, of a text, or of an enumeration that is not
  /// Worded; a Worded one has its own.
  Setting& one_of(const std::vector<std::string_view>& words) {
    choices = words;
    return *this;
  }
  /// The option of the program without its hyphens, if it is not that of the key; of a bool that is
  /// true by default, the flag that makes it false.
  Setting& option(std::string_view name) {
    option_name = name;
    return *this;
  }
  /// A number that may be 0, which then means that it is not given.
  Setting& optional() {
    may_be_zero = true;
    return *this;
  }
  /// A number that may be 0, which the program writes as a word.
  Setting& or_word(std::string_view word) {
    zero_word = word;
    return optional();
  }
  Setting& at_least(double limit) {
    lowest = limit;
    return *this;
  }
  Setting& at_most(double limit) {
    highest = limit;
    return *this;
  }
  /// What gives the setting an effect: whether it is there, and its words in messages.
  Setting& needs(bool is_there, std::string_view what) {
    if (!is_there) lacks = what;
    return *this;
  }
  /// Entries begin with names, up to this character, and each name occurs once.
  Setting& names_once(char end) {
    name_end = end;
    return *this;
  }
  /// A number between 0 and 1, without these.
  Setting& share() {
    is_share = true;
    return *this;
  }

  T& value;
};

/// T itself or a const T.
template <typename S, typename T>
concept Same = std::same_as<std::remove_const_t<S>, T>;

/// What is wrong with a number for a setting; empty if it is allowed. A whole number that is not
/// optional is at least 1.
std::string wrong_number(const SettingHead& setting, double value, bool is_whole = false);

/// \throws UsageError that names the setting
[[noreturn]] void refuse(const SettingHead& setting, const std::string& problem);

/// \throws UsageError that names the setting if its number is not allowed
template <typename T>
void require_number(const Setting<T>& setting) {
  const std::string wrong =
      wrong_number(setting, static_cast<double>(setting.value), std::integral<T>);
  if (!wrong.empty()) refuse(setting, wrong);
}

/// \throws UsageError that names the setting and the name of two entries, see names_once
void require_names_once(const SettingHead& setting, const std::vector<std::string>& entries);

/// Whether the values of a type are words.
template <typename T>
struct HasWords : std::bool_constant<std::is_enum_v<ValueOf<T>>> {};

/// The number of a word.
/// \throws UsageError that lists the words if it is unknown
std::size_t choice_of(const SettingHead& setting, std::string_view word);

/// Sets the value of a word of a text, bool or enumeration. The empty word changes nothing.
template <typename T>
void set_word(const Setting<T>& setting, const std::string& word) {
  if (word.empty()) return;
  const std::size_t choice = choice_of(setting, word);
  if constexpr (std::same_as<T, std::string>) {
    setting.value = word;
  } else if constexpr (requires { typename T::value_type; }) {
    setting.value = static_cast<typename T::value_type>(choice);
  } else {
    setting.value = static_cast<T>(choice);
  }
}

/// The word of a bool or an enumeration; empty for std::nullopt.
template <typename T>
std::string word_of(const Setting<T>& setting) {
  if constexpr (requires { setting.value.has_value(); }) {
    if (!setting.value) return {};
    return std::string(setting.choices.at(static_cast<std::size_t>(*setting.value)));
  } else {
    return std::string(setting.choices.at(static_cast<std::size_t>(setting.value)));
  }
}

}  // namespace silvafit::data
