// SPDX-License-Identifier: MIT
#include "sheet_options.hpp"

namespace silvafit::cli {

void add_missing_option(CLI::App& command, SheetArguments& arguments) {
  command
      .add_option("--missing",
                  arguments.missing,
                  "Further texts or numbers for missing values, such as -88,unknown (known are "
                  "empty fields, NA, -, n/a and the like, -999, and 0 where it cannot be)")
      ->delimiter(',')
      ->type_name("CODE,...")
      ->allow_extra_args(false);
}

void add_fill_down_option(CLI::App& command, SheetArguments& arguments) {
  command
      .add_option(
          "--fill-down",
          arguments.fill_down,
          "Columns whose empty fields have the value above, as merged cells are saved, such "
          "as plot,species")
      ->delimiter(',')
      ->type_name("COLUMN,...")
      ->allow_extra_args(false);
}

void add_sheet_options(CLI::App& command, SheetArguments& arguments) {
  add_missing_option(command, arguments);
  add_fill_down_option(command, arguments);
  command.add_flag("--case-sensitive",
                   arguments.case_sensitive,
                   "Species that differ only in capitals, accents or blanks are different");
}

void add_dead_option(CLI::App& command, SheetArguments& arguments) {
  command
      .add_option("--dead",
                  arguments.dead,
                  "Standing dead trees, by a column of the status: leave-out; neighbors (they are "
                  "neighbors of living trees, but in no figure and no model); include (as living "
                  "ones; cut and fallen trees, too)")
      ->check(CLI::IsMember({"leave-out", "neighbors", "include"}))
      ->capture_default_str();
}

void add_trust_units_option(CLI::App& command, bool& trust_units) {
  command.add_flag("--trust-units",
                   trust_units,
                   "Do not ask whether a column, or some plots, have another unit");
}

stand::DeadTrees dead_trees(const SheetArguments& arguments) {
  if (arguments.dead == "neighbors") return stand::DeadTrees::kNeighbors;
  return arguments.dead == "include" ? stand::DeadTrees::kInclude : stand::DeadTrees::kLeaveOut;
}

}  // namespace silvafit::cli
