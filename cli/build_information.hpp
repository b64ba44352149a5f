// SPDX-License-Identifier: MIT
// The output of --version: the version, its dependencies and the build.
#pragma once

#include <CLI/CLI.hpp>

namespace silvafit::cli {

/// Adds --version, and --json, which is valid only with it.
void add_version_options(CLI::App& program);

/// Adds --version to all commands below; with their --json, it is JSON.
void add_version_to_commands(CLI::App& program);

}  // namespace silvafit::cli
