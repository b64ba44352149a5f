// SPDX-License-Identifier: MIT
// Commands and options that do not exist, and what they may have been meant to be.
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

}  // namespace silvafit::cli
