// SPDX-License-Identifier: MIT
// Messages about unknown commands, options and values, with suggestions.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace silvafit::cli {

/// \param words  the command line without the program's name
/// \throws UsageError with a list of the commands if they name no command
void require_command(const CLI::App& program, const std::vector<std::string>& words);

/// The message about words that are neither options nor arguments of the command.
std::string unexpected_words(const CLI::App& program);

/// Restricts the values of all count options to digits: otherwise a negative number would become a
/// very large one.
void require_whole_numbers(CLI::App& program);

/// The message about a value or option that could not be read, with the option's name.
std::string unreadable_words(const CLI::App& program, const CLI::ParseError& error);

}  // namespace silvafit::cli
