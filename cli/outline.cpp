// SPDX-License-Identifier: MIT
#include "outline.hpp"

#include <fmt/format.h>

namespace silvafit::cli {
namespace {

// CLI11 keeps the choices of an option as the end of its type's name: `TEXT:{wald,profile}`.
std::vector<std::string> choices_in(std::string& type) {
  const std::size_t begin = type.find(":{");
  if (begin == std::string::npos || type.back() != '}') return {};
  const std::string list = type.substr(begin + 2, type.size() - begin - 3);
  type.erase(begin);
  return CLI::detail::split(list, ',');
}

OptionOutline outline_of(const CLI::Option& option) {
  OptionOutline result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  if (option.get_positional()) result.names.push_back(option.get_name(true));
  if (option.get_items_expected_max() > 0) {
    result.value = option.get_type_name();
    result.choices = choices_in(result.value);
  }
  result.default_value = option.get_default_str();
  result.description = option.get_description();
  result.required = option.get_required();
  result.repeatable = option.get_items_expected_max() > 1;
  return result;
}

std::string example_in(const std::string& footer) {
  const std::string heading = "Example:\n";
  std::string example;
  if (footer.rfind(heading, 0) != 0) return example;
  for (std::string& line : CLI::detail::split(footer.substr(heading.size()), '\n')) {
    example += CLI::detail::ltrim(line) + "\n";
  }
  return example;
}

CommandOutline outline_below(const CLI::App& command, std::vector<std::string> words) {
  words.push_back(command.get_name());
  CommandOutline result;
  result.words = words;
  result.description = command.get_description();
  result.example = example_in(command.get_footer());
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;
    auto& list = option->get_positional() ? result.arguments : result.options;
    list.push_back(outline_of(*option));
  }
  const auto is_visible = [](const CLI::App* below) { return !below->get_group().empty(); };
  for (const CLI::App* below : command.get_subcommands(is_visible)) {
    result.commands.push_back(outline_below(*below, words));
  }
  return result;
}

void add_all(const CommandOutline& command, std::vector<const CommandOutline*>& commands) {
  commands.push_back(&command);
  for (const CommandOutline& below : command.commands) add_all(below, commands);
}

}  // namespace

std::vector<std::string> choices_of(const CLI::Option& option) {
  std::string type = option.get_type_name();
  return choices_in(type);
}

CommandOutline outline(const CLI::App& program) { return outline_below(program, {}); }

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  return fmt::format("{}", fmt::join(words, between));
}

std::vector<const CommandOutline*> all_commands(const CommandOutline& command) {
  std::vector<const CommandOutline*> commands;
  add_all(command, commands);
  return commands;
}

}  // namespace silvafit::cli
