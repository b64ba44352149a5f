// SPDX-License-Identifier: MIT
// What --help says of commands and options, for completions, manual pages and messages.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace silvafit::cli {

/// The commands of a program or command, without hidden ones.
std::vector<const CLI::App*> commands_below(const CLI::App& app);

/// `silvafit library scenes`, or with another text between the words.
std::string words_of(const CLI::App& app, const std::string& between = " ");

/// `-h`, `--help`.
std::vector<std::string> names_of(const CLI::Option& option);

/// The valid values of an option; empty if there is no list of them.
std::vector<std::string> choices_of(const CLI::Option& option);

/// The word for the value of an option or argument, `FILE.csv`; empty: a flag.
std::string value_of(const CLI::Option& option);

}  // namespace silvafit::cli
