// SPDX-License-Identifier: MIT
// Options of the command line from lists of settings.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/idle_settings.hpp"

namespace silvafit::cli {

/// The option of a key: `fill_down` is --fill-down.
std::string option_of(std::string_view key);

/// A visitor that adds an option for each setting. Settings of other types than the overloads have
/// no option.
class SettingOptions {
 public:
  /// \param section  of the help
  /// \param only     the keys of the settings that get options; empty: all
  SettingOptions(CLI::App& command, std::string section, std::vector<std::string_view> only = {})
      : command_(command), section_(std::move(section)), only_(std::move(only)) {}

  template <typename T>
  void operator()(const data::Setting<T>& setting) {
    const bool is_wanted = only_.empty() || std::ranges::find(only_, setting.key) != only_.end();
    if (!is_wanted) return;
    if constexpr (data::HasWords<T>::value || std::same_as<T, bool>) {
      if (!setting.choices.empty()) return add_words(setting, data::word_of(setting));
    } else if constexpr (std::same_as<T, std::string>) {
      if (!setting.choices.empty()) return add_words(setting, setting.value);
    }
    if constexpr (requires { add(setting); }) finish(add(setting), setting);
  }

 private:
  template <typename T>
  void add_words(const data::Setting<T>& setting, const std::string& word) {
    const auto set = [setting](const std::string& text) { data::set_word(setting, text); };
    finish(add_choice(setting, word, set), setting);
  }
  CLI::Option* add_choice(const data::SettingHead& setting,
                          const std::string& word,
                          const std::function<void(const std::string&)>& set);
  template <typename Number>
  CLI::Option* add_number(const data::Setting<Number>& setting);
  template <typename T>
  CLI::Option* add_list(const data::Setting<std::vector<T>>& setting);
  CLI::Option* add(const data::Setting<bool>& setting);
  CLI::Option* add(const data::Setting<int>& setting);
  CLI::Option* add(const data::Setting<double>& setting);
  CLI::Option* add(const data::Setting<std::optional<double>>& setting);
  CLI::Option* add(const data::Setting<std::size_t>& setting);
  CLI::Option* add(const data::Setting<std::string>& setting);
  CLI::Option* add(const data::Setting<std::vector<std::string>>& setting);
  CLI::Option* add(const data::Setting<std::vector<int>>& setting);
  CLI::Option* add(const data::Setting<std::vector<double>>& setting);
  CLI::Option* add(const data::Setting<std::map<std::string, double>>& setting);
  CLI::Option* add(const data::Setting<std::map<std::string, fit::Bounds>>& setting);
  void finish(CLI::Option* option, const data::SettingHead& setting) const;

  CLI::App& command_;
  std::string section_;
  std::vector<std::string_view> only_;
};

/// The options of settings that a command line gives.
study::GivenName given_options(const CLI::App& command);

/// Whether an option of the command line gives a setting.
bool is_given(const CLI::App& command, std::string_view key);

}  // namespace silvafit::cli
