// SPDX-License-Identifier: MIT
// The options and arguments of all commands as data. Completions and manual pages are written from
// it, so that they agree with --help.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace silvafit::cli {

/// An option, or an argument without a name of its own.
struct OptionOutline {
  std::vector<std::string> names{};    ///< `-h`, `--help`; of an argument its name alone
  std::string value{};                 ///< word for its value, `FILE.csv`; empty: a flag
  std::vector<std::string> choices{};  ///< the valid values, if they are listed
  std::string default_value{};
  std::string description{};
  bool required = false;
  bool repeatable = false;
};

/// A command, with those below it.
struct CommandOutline {
  std::vector<std::string> words{};  ///< `silvafit`, `library`, `scenes`
  std::string description{};
  std::vector<OptionOutline> arguments{};
  std::vector<OptionOutline> options{};
  std::vector<CommandOutline> commands{};
  std::string example{};  ///< command lines
};

/// The valid values of an option; empty if there is no list of them.
std::vector<std::string> choices_of(const CLI::Option& option);

/// The outline of the program, without hidden commands.
CommandOutline outline(const CLI::App& program);

/// The words of a command, separated by `between`: `silvafit library scenes`.
std::string joined(const std::vector<std::string>& words, const std::string& between = " ");

/// The command and all below it, each before those below it.
std::vector<const CommandOutline*> all_commands(const CommandOutline& command);

}  // namespace silvafit::cli
