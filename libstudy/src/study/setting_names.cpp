// SPDX-License-Identifier: MIT
#include "silvafit/study/setting_names.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/study/setting_lists.hpp"

namespace silvafit::study {
namespace {

/// Settings that only the program has, which messages name.
constexpr auto kSettingsOfProgram = std::to_array<std::string_view>({"allow_network",
                                                                     "growth",
                                                                     "json",
                                                                     "layer",
                                                                     "plots_sql",
                                                                     "sql",
                                                                     "stream",
                                                                     "target",
                                                                     "tile",
                                                                     "trees",
                                                                     "window_layer",
                                                                     "zoom"});
/// Settings for which users of R have another word.
constexpr auto kWordsOfR = std::to_array<std::pair<std::string_view, std::string_view>>(
    {{"bounds", "lower, upper"},
     {"maximum_iterations", "max_iterations"},
     {"scene", "file"},
     {"standard_errors", "se.fit"}});
/// Commands that are functions in R and in Python.
struct Function {
  std::string_view command{};
  std::string_view r{};
  std::string_view python{};
};
constexpr auto kFunctions =
    std::to_array<Function>({{"fit", "silvafit", "fit"},
                             {"grow", "grow_trees", "grow"},
                             {"impute", "impute", "impute"},
                             {"indices", "structural_units", "structural_units"},
                             {"study", "fit_study", "study"}});

struct SettingName {
  std::string option{};  ///< --fill-down
  bool is_mapping = false;
};
using SettingNames = std::map<std::string, SettingName, std::less<>>;

SettingNames all_names() {
  SettingNames names;
  const auto add = [&names](std::string_view key, std::string_view option, bool is_mapping) {
    std::string name = "--" + std::string(option.empty() ? key : option);
    std::ranges::replace(name, '_', '-');
    names.emplace(key, SettingName{std::move(name), is_mapping});
  };
  const auto add_setting = [&add](const auto& setting) {
    add(setting.key, setting.option_name, setting.form == data::SettingForm::kMapping);
  };
  // The first one of a name counts: `plots` is the table of plots, not those of grown trees.
  each_setting_list([&add_setting](std::string_view /*name*/, const auto& settings) {
    each_setting(settings, add_setting);
  });
  const TileSettings tiles;
  each_setting(tiles, add_setting);
  for (const std::string_view key : kSettingsOfProgram) add(key, "", false);
  return names;
}

std::string in_quotes(std::string_view value) {
  const char quote = value.find_first_of("\"`$") == std::string_view::npos ? '"' : '\'';
  return fmt::format("{0}{1}{0}", quote, value);
}

/// \throws UsageError if a column in the text contains a comma
std::string mapping_text(std::string_view text, bool is_r) {
  std::vector<std::string> parts;
  for (const auto& [name, source] : stand::parse_column_mappings(text)) {
    parts.push_back(is_r ? fmt::format("{} = {}", name, in_quotes(source))
                         : fmt::format("{}: {}", in_quotes(name), in_quotes(source)));
  }
  const std::string joined = fmt::format("{}", fmt::join(parts, ", "));
  return is_r ? fmt::format("c({})", joined) : fmt::format("{{{}}}", joined);
}

std::string argument_value(const SettingName& name, std::string_view value, bool is_r) try {
  double number = 0.0;
  if (value == "true") return is_r ? "TRUE" : "True";
  if (value == "false") return is_r ? "FALSE" : "False";
  if (data::parse_number(value, number)) return std::string(value);
  return name.is_mapping ? mapping_text(value, is_r) : in_quotes(value);
} catch (const UsageError&) {
  return in_quotes(value);
}

std::string setting_text(const SettingNames::value_type& setting,
                         std::string_view value,
                         Front front) {
  const auto& [key, name] = setting;
  const bool is_flag = value.empty() || value == "true" || value == "false";
  if (front == Front::kProgram) {
    const bool is_word = value.find_first_of(" \"'`$?;&|<>()") == std::string_view::npos;
    if (is_flag) return name.option;
    return fmt::format("{} {}", name.option, is_word ? std::string(value) : in_quotes(value));
  }
  const bool is_r = front == Front::kR;
  const std::string_view argument = is_r ? argument_of_r(key) : key;
  if (value.empty()) return fmt::format("`{}`", argument);
  return fmt::format("{}{}{}", argument, is_r ? " = " : "=", argument_value(name, value, is_r));
}

/// What replaces the words between backquotes, and these; nothing if they are no setting.
std::optional<std::string> replaced(std::string_view words, Front front) {
  static const SettingNames names = all_names();
  constexpr std::string_view kProgram = "silvafit ";
  if (words.starts_with(kProgram) && front != Front::kProgram) {
    words.remove_prefix(kProgram.size());
    const auto function = std::ranges::find(kFunctions, words, &Function::command);
    if (function == kFunctions.end()) return std::nullopt;
    return fmt::format("`{}()`", front == Front::kR ? function->r : function->python);
  }
  const std::size_t sign = std::min(words.find('='), words.size());
  const auto setting = names.find(words.substr(0, sign));
  if (setting == names.end()) return std::nullopt;
  return setting_text(*setting, words.substr(std::min(sign + 1, words.size())), front);
}

/// The backquote that ends the words after another one. Names with backquotes of their own follow
/// an operator: `columns=h=`Height (m)`/10`.
std::size_t end_of_words(std::string_view text, std::size_t begin) {
  bool is_inside = false;
  for (std::size_t i = begin + 1; i < text.size(); ++i) {
    if (text[i] != '`') continue;
    if (!is_inside && std::string_view("=(,+-*/^").find(text[i - 1]) == std::string_view::npos) {
      return i;
    }
    is_inside = !is_inside;
  }
  return std::string_view::npos;
}

}  // namespace

std::string with_setting_names(std::string_view text, Front front) {
  std::string result;
  std::size_t begin = 0;
  while ((begin = text.find('`')) != std::string_view::npos) {
    const std::size_t end = end_of_words(text, begin);
    if (end == std::string_view::npos) break;
    const auto words = replaced(text.substr(begin + 1, end - begin - 1), front);
    // A backquote that ends other words may begin some.
    result += text.substr(0, words ? begin : begin + 1);
    result += words.value_or("");
    text.remove_prefix(words ? end + 1 : begin + 1);
  }
  return result.append(text);
}

std::string_view argument_of_r(std::string_view key) {
  const auto other = std::ranges::find(kWordsOfR, key, [](const auto& pair) { return pair.first; });
  return other == kWordsOfR.end() ? key : other->second;
}

std::string name_of_place(std::string_view column) {
  const bool is_setting = column.size() > 2 && column.front() == '`' && column.back() == '`';
  return std::string(is_setting ? column.substr(1, column.size() - 2) : column);
}

}  // namespace silvafit::study
