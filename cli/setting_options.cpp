// SPDX-License-Identifier: MIT
#include "setting_options.hpp"

#include "name_list.hpp"

namespace silvafit::cli {
namespace {

using data::Setting;

std::vector<std::string> texts_of(const std::vector<std::string_view>& words) {
  return {words.begin(), words.end()};
}

template <typename T>
std::string name_of(const Setting<T>& setting) {
  return setting.option_name.empty() ? option_of(setting.key) : std::string(setting.option_name);
}

/// A number of 0 may be written only if it differs from the default, which means "not given".
template <typename Number>
CLI::Option* add_number(CLI::App& command, const Setting<Number>& setting) {
  CLI::Option* const option =
      command.add_option(name_of(setting), setting.value, std::string(setting.help));
  const bool allows_zero = setting.may_be_zero && setting.value != Number{};
  if (setting.highest > 0.0) {
    const auto lowest = static_cast<Number>(setting.may_be_zero ? 0 : 1);
    option->check(CLI::Range(lowest, static_cast<Number>(setting.highest)));
  } else {
    option->check(allows_zero ? CLI::NonNegativeNumber : CLI::PositiveNumber);
  }
  if (setting.value != Number{}) option->capture_default_str();
  return option;
}

}  // namespace

std::string option_of(std::string_view key) {
  std::string option = "--" + std::string(key);
  std::ranges::replace(option, '_', '-');
  return option;
}

CLI::Option* SettingOptions::add(const Setting<bool>& setting) {
  const std::string name = name_of(setting);
  const std::string help(setting.help);
  if (setting.choices.empty() && setting.value) {
    return command_.add_flag_callback(
        name, [&value = setting.value] { value = false; }, help);
  }
  if (setting.choices.empty()) return command_.add_flag(name, setting.value, help);
  const auto read = [words = setting.choices, &value = setting.value](const std::string& text) {
    value = text == words.back();
  };
  return command_.add_option_function<std::string>(name, read, help)
      ->check(CLI::IsMember(texts_of(setting.choices)))
      ->default_str(std::string(setting.choices[setting.value ? 1 : 0]));
}

CLI::Option* SettingOptions::add(const Setting<double>& setting) {
  return add_number(command_, setting);
}

CLI::Option* SettingOptions::add(const Setting<std::size_t>& setting) {
  return add_number(command_, setting);
}

CLI::Option* SettingOptions::add(const Setting<std::string>& setting) {
  CLI::Option* const option =
      command_.add_option(name_of(setting), setting.value, std::string(setting.help));
  if (!setting.choices.empty()) option->check(CLI::IsMember(texts_of(setting.choices)));
  if (!setting.value.empty()) option->capture_default_str();
  return option;
}

CLI::Option* SettingOptions::add(const Setting<std::vector<std::string>>& setting) {
  const std::string name = name_of(setting);
  const std::string help(setting.help);
  if (setting.form == data::SettingForm::kNames) {
    return add_names_option(command_, name, setting.value, help);
  }
  CLI::Option* const option = command_.add_option(name, setting.value, help);
  // Formulas of columns contain commas.
  if (setting.form != data::SettingForm::kMapping) option->delimiter(',');
  if (!setting.value.empty()) option->capture_default_str();
  return option->allow_extra_args(false);
}

CLI::Option* SettingOptions::add(const Setting<std::vector<int>>& setting) {
  return command_.add_option(name_of(setting), setting.value, std::string(setting.help))
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
}

CLI::Option* SettingOptions::add(const Setting<tree::BuilderKind>& setting) {
  std::vector<std::string> builders;
  for (const tree::BuilderKind kind : tree::builder_kinds()) {
    builders.emplace_back(tree::builder_name(kind));
  }
  const auto read = [&value = setting.value](const std::string& name) {
    value = tree::builder_from_text(name);
  };
  return command_
      .add_option_function<std::string>(name_of(setting), read, std::string(setting.help))
      ->check(CLI::IsMember(builders))
      ->default_str(tree::builder_name(setting.value));
}

void SettingOptions::finish(CLI::Option* option, std::string_view type_name) const {
  option->group(section_);
  if (!type_name.empty()) option->type_name(std::string(type_name));
}

bool is_given(const CLI::App& command, std::string_view key) {
  const CLI::Option* const option = command.get_option_no_throw(option_of(key));
  return option != nullptr && option->count() > 0;
}

}  // namespace silvafit::cli
