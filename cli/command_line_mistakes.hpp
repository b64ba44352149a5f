// SPDX-License-Identifier: MIT
// Commands, options and values that do not exist, and what they may have been meant to be.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace silvafit::cli {

/// \param words  the command line without the program's name
/// \throws UsageError if they name no command; it lists those that there are
void require_command(const CLI::App& program, const std::vector<std::string>& words);

/// What is wrong with words that were left over when the command line had been read.
std::string unexpected_words(const CLI::App& program);

/// Lets the options of all commands that are counts take nothing but digits: a number below 0 would
/// otherwise become a very large one.
void require_whole_numbers(CLI::App& program);

/// What is wrong with a value or option that could not be read, with the option's name.
std::string unreadable_words(const CLI::App& program, const CLI::ParseError& error);

}  // namespace silvafit::cli
