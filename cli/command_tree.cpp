// SPDX-License-Identifier: MIT
#include "command_tree.hpp"

namespace silvafit::cli {
namespace {

// CLI11 keeps the choices of an option as the end of its type's name: `TEXT:{wald,profile}`.
constexpr char kBeforeChoices[] = ":{";

}  // namespace

std::vector<const CLI::App*> commands_below(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* below) { return !below->get_group().empty(); });
}

std::string words_of(const CLI::App& app, const std::string& between) {
  const CLI::App* const above = app.get_parent();
  return above == nullptr ? app.get_name() : words_of(*above, between) + between + app.get_name();
}

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find(kBeforeChoices);
  if (begin == std::string::npos || type.back() != '}') return {};
  return CLI::detail::split(type.substr(begin + 2, type.size() - begin - 3), ',');
}

std::string value_of(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return {};
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(kBeforeChoices));
}

}  // namespace silvafit::cli
