// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <limits>

#include "command_tree.hpp"
#include "program.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/near_names.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::cli {
namespace {

std::vector<std::string> command_names(const std::vector<const CLI::App*>& commands) {
  std::vector<std::string> names;
  names.reserve(commands.size());
  for (const CLI::App* command : commands) names.push_back(command->get_name());
  return names;
}

/// A table in place of a command.
void refuse_table(const std::string& word) {
  const std::string ending = std::filesystem::path(word).extension().string();
  constexpr std::array<std::string_view, 8> kTables{
      ".csv", ".txt", ".tsv", ".xlsx", ".ods", ".gpkg", ".sqlite", ".fgb"};
  if (std::ranges::find(kTables, ending) == kTables.end() && !is_there(word)) return;
  throw UsageError(fmt::format(
      "'{0}' is not a command. For a table of trees: silvafit study {0} --out results "
      "makes models and a report, silvafit stand {0} stand tables, and silvafit columns "
      "{0} shows how the table is read",
      word));
}

/// "; did you mean fit?", or the given end of the sentence if there is no similar name.
std::string suggestion(const std::string& word,
                       const std::vector<std::string>& names,
                       const char* otherwise) {
  const std::string nearest = nearest_name(word, names);
  return nearest.empty() ? otherwise : fmt::format("; did you mean {}?", nearest);
}

/// The innermost command of the command line: of `library scenes`, scenes.
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

/// The error in the text of a count; empty if it is valid.
std::string wrong_count(const std::string& text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string::npos) {
    return fmt::format("'{}' is not a whole number of 0 or more", text);
  }
  std::uint64_t count = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), count);
  return read.ec == std::errc() ? std::string() : fmt::format("{} is too large", text);
}

bool is_count(const CLI::Option& option) { return option.get_type_name().starts_with("UINT"); }

/// The error in a value of an option that cannot be read; empty if it is valid.
std::string wrong_value(const CLI::Option& option, const std::string& value) {
  const std::vector<std::string> choices = choices_of(option);
  if (!choices.empty()) {
    if (std::ranges::find(choices, value) != choices.end()) return {};
    return fmt::format(
        "'{}' is not one of {}{}", value, fmt::join(choices, ", "), suggestion(value, choices, ""));
  }
  if (option.get_items_expected_max() == 0) return "takes no value";
  if (is_count(option)) return wrong_count(value);
  double number = 0.0;
  if (!data::parse_number(data::trimmed(value), number)) {
    return fmt::format("'{}' is not a number", value);
  }
  return {};
}

/// The option to which a parse error belongs.
const CLI::Option* option_of(const CLI::App& command, const std::string& message) {
  const CLI::Option* found = nullptr;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    // The longest name, because a name may be a prefix of another.
    const bool is_longer = found == nullptr || name.size() > found->get_name().size();
    if (is_longer && !name.empty() && message.find(name) != std::string::npos) found = option;
  }
  return found;
}

/// `--threads`, or the word for an argument in --help: `INVENTORY.csv`.
std::string shown_name(const CLI::Option& option) {
  const bool is_argument = option.get_positional();
  return is_argument && option.get_type_name().find("TEXT") == std::string::npos
             ? option.get_type_name()
             : option.get_name();
}

/// Where a word without an option belongs.
std::string place_of(const std::string& word, const CLI::App& command) {
  const std::vector<std::string> options = option_names(command);
  const bool has_formula = std::ranges::find(options, "--formula") != options.end();
  if (has_formula && word.find('~') != std::string::npos) {
    return fmt::format("write --formula '{}'", word);
  }
  if (word.find(' ') == std::string::npos) return "put text with spaces in quotes";
  return fmt::format("text follows the name of an option; {} --help lists them", words_of(command));
}

}  // namespace

void require_filled(const std::vector<std::string>& words) {
  // What a shell completes may be empty.
  const auto end = std::ranges::find(words, "--");
  for (std::size_t i = 0; i < static_cast<std::size_t>(end - words.begin()); ++i) {
    const bool ends_empty = words[i].starts_with("--") && words[i].ends_with('=');
    if (!words[i].empty() && !ends_empty) continue;
    const bool has_option = i > 0 && words[i].empty() && words[i - 1].starts_with('-');
    throw UsageError("the value is empty, as an unset variable of the shell is; omit it or fill it",
                     {.column = ends_empty   ? words[i].substr(0, words[i].size() - 1)
                                : has_option ? words[i - 1]
                                             : fmt::format("word {}", i + 1)});
  }
}

void require_command(const CLI::App& program, const std::vector<std::string>& words) {
  const CLI::App* app = &program;
  for (const std::string& word : words) {
    const std::vector<const CLI::App*> commands = commands_below(*app);
    if (commands.empty() || word.starts_with("--help") || word == "-h" || word == "--version")
      return;
    if (word.starts_with('-')) continue;
    const auto found = std::ranges::find(commands, word, &CLI::App::get_name);
    if (found == commands.end()) {
      refuse_table(word);
      const std::vector<std::string> names = command_names(commands);
      throw UsageError(fmt::format("unknown command '{}'{} The commands are {}; see {} --help",
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
      fmt::format("a command is needed after {0}. The commands are {1}; see {0} --help",
                  words_of(*app),
                  fmt::join(command_names(commands), ", ")));
}

std::string unexpected_words(const CLI::App& program) {
  const CLI::App& command = read_command(program);
  const std::vector<std::string> words = program.remaining(true);
  const auto option =
      std::ranges::find_if(words, [](const std::string& word) { return word.starts_with("-"); });
  if (option != words.end()) {
    const std::string name = option->substr(0, option->find('='));
    return fmt::format("unknown option {}{} {} --help lists the options",
                       name,
                       suggestion(name, option_names(command), ";"),
                       words_of(command));
  }
  const std::string word = words.empty() ? "" : words.front();
  return fmt::format(
      "unexpected argument '{}' of {}; {}", word, words_of(command), place_of(word, command));
}

void require_whole_numbers(CLI::App& program) {
  for (CLI::Option* option : program.get_options()) {
    if (!option->get_type_name().starts_with("UINT")) continue;
    option->check(wrong_count);
  }
  for (CLI::App* command : program.get_subcommands([](CLI::App*) { return true; })) {
    require_whole_numbers(*command);
  }
}

std::string unreadable_words(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App& command = read_command(program);
  std::string message = error.what();
  const CLI::Option* option = option_of(command, message);
  const auto is = [&error](CLI::ExitCodes code) {
    return error.get_exit_code() == static_cast<int>(code);
  };
  const std::string help = fmt::format("{} --help lists the options", words_of(command));
  if (option == nullptr) return fmt::format("{}; {}", message, help);
  const std::string name = shown_name(*option);
  if (is(CLI::ExitCodes::RequiredError)) return fmt::format("{} is needed; {}", name, help);
  if (is(CLI::ExitCodes::ArgumentMismatch) && option->results().empty()) {
    return fmt::format("{}: needs a value; {}", name, help);
  }
  // The message of our own check is complete.
  const bool has_choices = !choices_of(*option).empty();
  const bool is_unsaid = is(CLI::ExitCodes::ConversionError) || has_choices || is_count(*option);
  for (const std::string& value : option->results()) {
    const std::string wrong = is_unsaid ? wrong_value(*option, value) : std::string();
    if (!wrong.empty()) return fmt::format("{}: {}", name, wrong);
  }
  if (is(CLI::ExitCodes::ConversionError)) {
    return fmt::format("{}: {} is too large", name, fmt::join(option->results(), ","));
  }
  // CLI11 prints a range without an upper limit with the largest double.
  if (message.ends_with(std::to_string(std::numeric_limits<double>::max()))) {
    for (const std::string& value : option->results()) {
      const std::string wrong = wrong_value(*option, value);
      if (!wrong.empty()) return fmt::format("{}: {}", name, wrong);
    }
    const bool may_be_zero = option->get_type_name().find("NONNEGATIVE") != std::string::npos;
    return fmt::format("{}: '{}' is {} 0",
                       name,
                       fmt::join(option->results(), ","),
                       may_be_zero ? "below" : "not above");
  }
  return message;
}

}  // namespace silvafit::cli
