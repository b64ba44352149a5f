// SPDX-License-Identifier: MIT
// The texts of --help and --help-all.
#pragma once

#include <CLI/CLI.hpp>

namespace silvafit::cli {

/// Headings of options that many commands have; lists of settings have headings of their own.
inline constexpr char kInputSection[] = "Table of trees";
inline constexpr char kOutputSection[] = "Output";

/// Makes --help of commands with many options list those that most people need, and --help-all all
/// of them, by sections. To be called before commands are added.
void add_short_help(CLI::App& program);

}  // namespace silvafit::cli
