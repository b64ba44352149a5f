// SPDX-License-Identifier: MIT
#include "command_line_mistakes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "near_names.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::cli {
namespace {

std::vector<const CLI::App*> commands_below(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<std::string> names_of(const std::vector<const CLI::App*>& commands) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands) names.push_back(command->get_name());
  return names;
}

/// `silvafit library`
std::string words_of(const CLI::App& app) {
  const CLI::App* above = app.get_parent();
  return above == nullptr ? app.get_name() : words_of(*above) + " " + app.get_name();
}

/// "; did you mean fit?", or the mark that ends the sentence without one.
std::string suggestion(const std::string& word,
                       const std::vector<std::string>& names,
                       const char* otherwise) {
  const std::string nearest = nearest_name(word, names);
  return nearest.empty() ? otherwise : fmt::format("; did you mean {}?", nearest);
}

/// The command that was read, the last of `library scenes`.
const CLI::App& read_command(const CLI::App& program) {
  const std::vector<CLI::App*> read = program.get_subcommands();
  return read.empty() ? program : read_command(*read.front());
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

}  // namespace

void require_command(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* app = &program;
  for (const std::string& word : words) {
    const std::vector<const CLI::App*> commands = commands_below(*app);
    if (commands.empty() || word == "--help" || word == "-h" || word == "--version") return;
    if (word.starts_with('-')) continue;
    const auto found = std::ranges::find(commands, word, &CLI::App::get_name);
    if (found == commands.end()) {
      const std::vector<std::string> names = names_of(commands);
      throw UsageError(
          fmt::format("there is no command '{}'{} The commands are {}; {} --help "
                      "says what they do",
                      word,
                      suggestion(word, names, "."),
                      fmt::join(names, ", "),
                      words_of(*app)));
    }
    app = *found;
  }
  const std::vector<const CLI::App*> commands = commands_below(*app);
  if (commands.empty()) return;
  throw UsageError(
      fmt::format("a command is needed after {0}. The commands are {1}; {0} --help "
                  "says what they do",
                  words_of(*app),
                  fmt::join(names_of(commands), ", ")));
}

std::string unexpected_words(const CLI::App& program) {
  const CLI::App& command = read_command(program);
  const std::vector<std::string> words = program.remaining(true);
  const auto option =
      std::ranges::find_if(words, [](const std::string& word) { return word.starts_with("-"); });
  if (option != words.end()) {
    const std::string name = option->substr(0, option->find('='));
    return fmt::format("there is no option {}{} {} --help lists the options",
                       name,
                       suggestion(name, option_names(command), ";"),
                       words_of(command));
  }
  return fmt::format("'{}' is one word too many for {}; text with blanks goes in quotes",
                     words.empty() ? "" : words.front(),
                     words_of(command));
}

}  // namespace silvafit::cli
