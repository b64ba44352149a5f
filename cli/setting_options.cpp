// SPDX-License-Identifier: MIT
#include "setting_options.hpp"

#include <fmt/format.h>

#include "coefficient_values.hpp"
#include "name_list.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::cli {
namespace {

using data::Setting;
using data::SettingHead;

std::string name_of(const SettingHead& setting) {
  return setting.option_name.empty() ? option_of(setting.key) : option_of(setting.option_name);
}

std::string help_of(const SettingHead& setting) { return with_options(setting.help); }

std::string wrong_share(const SettingHead& setting, const std::string& text) {
  double value = 0.0;
  return data::wrong_number(setting, data::parse_number(text, value) ? value : -1.0);
}

/// A number, or a word for 0.
std::size_t number_or_word(const Setting<std::size_t>& setting, const std::string& text) {
  double value = 0.0;
  if (text == setting.zero_word) return 0;
  const bool is_count = text.find_first_not_of("0123456789") == std::string::npos;
  if (is_count && data::parse_number(text, value) && value >= setting.lowest && value <= 0x1p53) {
    return static_cast<std::size_t>(value);
  }
  throw UsageError(fmt::format("'{}' is neither a whole number of {} or more nor {}",
                               text,
                               setting.lowest,
                               setting.zero_word),
                   {.column = name_of(setting)});
}

}  // namespace

std::string option_of(std::string_view key) {
  std::string option = "--" + std::string(key);
  std::ranges::replace(option, '_', '-');
  return option;
}

CLI::Option* SettingOptions::add_choice(const SettingHead& setting,
                                        const std::string& word,
                                        const std::function<void(const std::string&)>& set) {
  CLI::Option* const option =
      command_.add_option_function<std::string>(name_of(setting), set, help_of(setting));
  option->check(
      CLI::IsMember(std::vector<std::string>(setting.choices.begin(), setting.choices.end())));
  return word.empty() ? option : option->default_str(word);
}

/// A number of 0 may be written only if it differs from the default, which means "not given".
template <typename Number>
CLI::Option* SettingOptions::add_number(const Setting<Number>& setting) {
  CLI::Option* const option =
      command_.add_option(name_of(setting), setting.value, help_of(setting));
  const bool allows_zero = setting.may_be_zero && setting.value != Number{};
  if (setting.is_share) {
    option->check(
        [head = SettingHead(setting)](const std::string& text) { return wrong_share(head, text); });
  } else if (setting.highest > 0.0) {
    const double lowest = std::max(setting.lowest, setting.may_be_zero ? 0.0 : 1.0);
    option->check(CLI::Range(static_cast<Number>(lowest), static_cast<Number>(setting.highest)));
  } else {
    option->check(allows_zero ? CLI::NonNegativeNumber : CLI::PositiveNumber);
  }
  if (setting.value != Number{}) option->capture_default_str();
  return option;
}

template <typename T>
CLI::Option* SettingOptions::add_list(const Setting<std::vector<T>>& setting) {
  CLI::Option* const option =
      command_.add_option(name_of(setting), setting.value, help_of(setting));
  // Formulas of columns contain commas.
  const bool has_commas =
      setting.form == data::SettingForm::kMapping || setting.form == data::SettingForm::kRepeatable;
  if (!has_commas) option->delimiter(',');
  if (!setting.value.empty()) option->capture_default_str();
  return option->allow_extra_args(false);
}

CLI::Option* SettingOptions::add(const Setting<bool>& setting) {
  if (!setting.value) return command_.add_flag(name_of(setting), setting.value, help_of(setting));
  return command_.add_flag_callback(
      name_of(setting), [&value = setting.value] { value = false; }, help_of(setting));
}

CLI::Option* SettingOptions::add(const Setting<int>& setting) { return add_number(setting); }

CLI::Option* SettingOptions::add(const Setting<double>& setting) { return add_number(setting); }

CLI::Option* SettingOptions::add(const Setting<std::optional<double>>& setting) {
  return command_.add_option(name_of(setting), setting.value, help_of(setting));
}

CLI::Option* SettingOptions::add(const Setting<std::size_t>& setting) {
  if (setting.zero_word.empty()) return add_number(setting);
  const auto read = [setting](const std::string& text) {
    setting.value = number_or_word(setting, text);
  };
  return command_.add_option_function<std::string>(name_of(setting), read, help_of(setting));
}

CLI::Option* SettingOptions::add(const Setting<std::string>& setting) {
  CLI::Option* const option =
      command_.add_option(name_of(setting), setting.value, help_of(setting));
  return setting.value.empty() ? option : option->capture_default_str();
}

CLI::Option* SettingOptions::add(const Setting<std::vector<std::string>>& setting) {
  if (setting.form != data::SettingForm::kNames) return add_list(setting);
  return add_names_option(command_, name_of(setting), setting.value, help_of(setting));
}

CLI::Option* SettingOptions::add(const Setting<std::vector<int>>& setting) {
  return add_list(setting);
}

CLI::Option* SettingOptions::add(const Setting<std::vector<double>>& setting) {
  return add_list(setting);
}

CLI::Option* SettingOptions::add(const Setting<std::map<std::string, double>>& setting) {
  std::string form(setting.type_name.substr(0, setting.type_name.find(',')));
  const auto read = [&value = setting.value, name = name_of(setting), form](
                        const std::string& text) { value = parse_values(text, name, form); };
  return command_.add_option_function<std::string>(name_of(setting), read, help_of(setting));
}

CLI::Option* SettingOptions::add(const Setting<std::map<std::string, fit::Bounds>>& setting) {
  const auto read = [&value = setting.value](const std::string& text) {
    value = parse_bounds(text);
  };
  return command_.add_option_function<std::string>(name_of(setting), read, help_of(setting));
}

void SettingOptions::finish(CLI::Option* option, const SettingHead& setting) const {
  option->group(section_);
  if (!setting.type_name.empty()) option->type_name(std::string(setting.type_name));
}

bool is_given(const CLI::App& command, std::string_view key) {
  const CLI::Option* const option = command.get_option_no_throw(option_of(key));
  return option != nullptr && option->count() > 0;
}

}  // namespace silvafit::cli
