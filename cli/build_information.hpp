// SPDX-License-Identifier: MIT
// What --version says: which silvafit this is, what it was built from and how.
#pragma once

#include <CLI/CLI.hpp>

namespace silvafit::cli {

/// Adds --version, and --json, which goes with it alone.
void add_version_options(CLI::App& program);

/// Adds --version to all commands below; with their --json, it is JSON.
void add_version_to_commands(CLI::App& program);

}  // namespace silvafit::cli
