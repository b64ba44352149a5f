// SPDX-License-Identifier: MIT
// What surrounds the commands: --version, messages about unknown words, the start from a desktop.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace silvafit::cli {

/// Adds --version, and --json, which is valid only with it.
void add_version_options(CLI::App& program);

/// Adds --version to all commands below; with their --json, it is JSON.
void add_version_to_commands(CLI::App& program);

/// \param words  the command line without the program's name
/// \throws UsageError with a list of the commands if they name no command
void require_command(const CLI::App& program, const std::vector<std::string>& words);

/// \param words  the command line without the program's name
/// \throws UsageError if one is empty, as an unset variable of the shell is
void require_filled(const std::vector<std::string>& words);

/// The message about words that are neither options nor arguments of the command.
std::string unexpected_words(const CLI::App& program);

/// Restricts the values of all count options to digits: otherwise a negative number would become a
/// very large one.
void require_whole_numbers(CLI::App& program);

/// The message about a value or option that could not be read, with the option's name.
std::string unreadable_words(const CLI::App& program, const CLI::ParseError& error);

/// Runs the program on the words of the command line. For a table that was dropped on it, this
/// is a study beside the file, whose report is then opened. Without words in a console window of
/// its own, it explains the first command. Such a window stays open until the user has read it.
/// \return the exit status
int run_as_started(const std::vector<std::string>& words,
                   const std::function<int(const std::vector<std::string>&)>& run);

}  // namespace silvafit::cli
