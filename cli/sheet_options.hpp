// SPDX-License-Identifier: MIT
// Options on what spreadsheets leave in files of trees: codes for missing values, merged cells,
// dead trees.
#pragma once

#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::cli {

struct SheetArguments {
  std::vector<std::string> missing{};
  std::vector<std::string> fill_down{};
  std::string dead = "leave-out";
  bool case_sensitive = false;
};

/// Adds --missing.
void add_missing_option(CLI::App& command, SheetArguments& arguments);

/// Adds --fill-down.
void add_fill_down_option(CLI::App& command, SheetArguments& arguments);

/// Adds these two and --case-sensitive.
void add_sheet_options(CLI::App& command, SheetArguments& arguments);

/// Adds --dead, for commands that use some of the trees.
void add_dead_option(CLI::App& command, SheetArguments& arguments);

/// Adds --trust-units.
void add_trust_units_option(CLI::App& command, bool& trust_units);

/// What --dead says.
stand::DeadTrees dead_trees(const SheetArguments& arguments);

}  // namespace silvafit::cli
