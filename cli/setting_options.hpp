// SPDX-License-Identifier: MIT
// Options of the command line from lists of settings.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command.hpp"
#include "silvafit/data/setting.hpp"
#include "silvafit/tree/builder.hpp"

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
    if constexpr (requires { add(setting); }) finish(add(setting), setting.type_name);
  }

 private:
  CLI::Option* add(const data::Setting<bool>& setting);
  CLI::Option* add(const data::Setting<double>& setting);
  CLI::Option* add(const data::Setting<std::size_t>& setting);
  CLI::Option* add(const data::Setting<std::string>& setting);
  CLI::Option* add(const data::Setting<std::vector<std::string>>& setting);
  CLI::Option* add(const data::Setting<std::vector<int>>& setting);
  CLI::Option* add(const data::Setting<tree::BuilderKind>& setting);
  void finish(CLI::Option* option, std::string_view type_name) const;

  CLI::App& command_;
  std::string section_;
  std::vector<std::string_view> only_;
};

/// Whether an option of the command line gives a setting.
bool is_given(const CLI::App& command, std::string_view key);

}  // namespace silvafit::cli
