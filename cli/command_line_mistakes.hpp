// SPDX-License-Identifier: MIT
// Messages about unknown commands, options and values, with suggestions.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace silvafit::cli {

/// \param words  the command line without the program's name
/// \throws UsageError if they name no command; the message lists the commands
void require_command(const CLI::App& program, const std::vector<std::string>& words);

/// The message about words that no option or argument of the command line takes.
std::string unexpected_words(const CLI::App& program);

/// Lets the options of all commands that are counts take nothing but digits: a number below 0 would
/// otherwise become a very large one.
void require_whole_numbers(CLI::App& program);

/// What is wrong with a value or option that could not be read, with the option's name.
std::string unreadable_words(const CLI::App& program, const CLI::ParseError& error);

}  // namespace silvafit::cli
