// SPDX-License-Identifier: MIT
#include "setting_options.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::cli {
namespace {

/// End of the part that begins at a position: a comma outside parentheses and quotes, because names
/// of coefficients may contain both: a:min(x, 20), a:(species == "oak, red").
std::size_t end_of_part(std::string_view text, std::size_t begin) {
  int depth = 0;
  char quote = '\0';
  for (std::size_t i = begin; i < text.size(); ++i) {
    const char byte = text[i];
    if (quote != '\0') {
      if (byte == quote) quote = '\0';
      continue;
    }
    if (byte == '"' || byte == '\'' || byte == '`') quote = byte;
    if (byte == ',' && depth == 0) return i;
    depth += static_cast<int>(byte == '(') - static_cast<int>(byte == ')');
  }
  return text.size();
}

/// The texts of `name=text,...` by name.
std::map<std::string, std::string_view> parse_assignments(std::string_view text,
                                                          const std::string& option,
                                                          const std::string& form) {
  std::map<std::string, std::string_view> result;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = end_of_part(text, begin);
    const std::string_view part = text.substr(begin, end - begin);
    // The name of a coefficient may contain a comparison: b:species == "SM".
    const std::size_t sign = part.rfind('=');
    if (sign == std::string_view::npos) {
      throw UsageError(fmt::format("'{}' is not {}", part, form), {.column = option});
    }
    const std::string name(data::trimmed(part.substr(0, sign)));
    if (!result.emplace(name, data::trimmed(part.substr(sign + 1))).second) {
      throw UsageError(fmt::format("'{}' is given twice", name), {.column = option});
    }
    begin = end + 1;
  }
  return result;
}

double parse_value(std::string_view text, const std::string& option) {
  double value = 0.0;
  if (data::parse_number(text, value)) return value;
  throw UsageError(fmt::format("'{}' is not a number", text), {.column = option});
}

/// Reads `a=30,b=0.03`.
/// \param option  its name, for messages
/// \param form    of a part, such as NAME=VALUE
/// \throws UsageError that names the option and the part that cannot be read
std::map<std::string, double> parse_values(const std::string& text,
                                           const std::string& option,
                                           const std::string& form) {
  std::map<std::string, double> values;
  for (const auto& [name, value] : parse_assignments(text, option, form)) {
    values[name] = parse_value(value, option);
  }
  return values;
}

/// Reads `a=0:40,b=0:`, the value of --bound; a side without a number has no bound.
/// \throws UsageError as parse_values
std::map<std::string, fit::Bounds> parse_bounds(const std::string& text) {
  const std::string option = "--bound";
  std::map<std::string, fit::Bounds> bounds;
  for (const auto& [name, range] : parse_assignments(text, option, "NAME=LOW:HIGH")) {
    const std::size_t colon = range.find(':');
    if (colon == std::string_view::npos) {
      throw UsageError(fmt::format("'{}' is not a range such as 0:1, 0: or :1", range),
                       {.column = option});
    }
    const std::string_view low = data::trimmed(range.substr(0, colon));
    const std::string_view high = data::trimmed(range.substr(colon + 1));
    if (!low.empty()) bounds[name].low = parse_value(low, option);
    if (!high.empty()) bounds[name].high = parse_value(high, option);
  }
  return bounds;
}

/// The names of `1,2,"B, north"`: commas within double quotes are part of a name, as in CSV, and
/// two quotes there are one.
std::vector<std::string> split_names(std::string_view text) {
  std::vector<std::string> names(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_quote = text[i] == '"';
    if (is_quote && is_quoted && i + 1 < text.size() && text[i + 1] == '"') {
      names.back() += '"';
      ++i;
    } else if (is_quote && (is_quoted || names.back().empty())) {
      is_quoted = !is_quoted;
    } else if (text[i] == ',' && !is_quoted) {
      names.emplace_back();
    } else {
      names.back() += text[i];
    }
  }
  return names;
}

/// Adds a repeatable option for names that are separated by commas.
CLI::Option* add_names_option(CLI::App& command,
                              const std::string& name,
                              std::vector<std::string>& names,
                              const std::string& description) {
  const auto take = [&names](const std::vector<std::string>& texts) {
    names.clear();
    for (const std::string& text : texts) {
      const std::vector<std::string> part = split_names(text);
      names.insert(names.end(), part.begin(), part.end());
    }
  };
  return command.add_option_function<std::vector<std::string>>(name, take, description)
      ->type_name("NAME,...");
}

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
  option->check([](const std::string& text) {
    return text.empty() ? std::string("the text is empty; omit the option") : std::string();
  });
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

study::GivenName given_options(const CLI::App& command) {
  return [&command](const SettingHead& setting) {
    const CLI::Option* const option = command.get_option_no_throw(name_of(setting));
    return option != nullptr && option->count() > 0 ? option->get_name() : "";
  };
}

bool is_given(const CLI::App& command, std::string_view key) {
  const CLI::Option* const option = command.get_option_no_throw(option_of(key));
  return option != nullptr && option->count() > 0;
}

}  // namespace silvafit::cli
