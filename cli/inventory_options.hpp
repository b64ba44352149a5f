// SPDX-License-Identifier: MIT
// Options of the commands that read inventories and compute structural units.
#pragma once

#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {

/// Adds --columns.
CLI::Option* add_columns_option(CLI::App& command,
                                study::ReadingSettings& settings,
                                const std::string& help);

/// Adds --missing.
void add_missing_option(CLI::App& command, study::ReadingSettings& settings);

/// Adds --fill-down.
void add_fill_down_option(CLI::App& command, study::ReadingSettings& settings);

/// Adds these two and --case-sensitive.
void add_sheet_options(CLI::App& command, study::ReadingSettings& settings);

/// Adds --dead, --alive-codes, --dead-codes and --cut-codes, for commands that use some of the
/// trees.
void add_dead_option(CLI::App& command, study::ReadingSettings& settings);

/// Adds --trust-units.
void add_trust_units_option(CLI::App& command, study::ReadingSettings& settings);

/// Adds INVENTORY, its layer and all of these.
void add_inventory_options(CLI::App& command,
                           std::string& inventory,
                           study::ReadingSettings& settings,
                           TableArguments& table);

/// The table of plots of --plots, before it is opened.
struct PlotsArgument {
  std::string file{};
  source::TableChoice choice{};
};

/// Adds --plots, --plots-layer, --plots-sql, --plots-columns, --circles, --angle-count,
/// --smallest-dbh, --expansion, --expansion-area, --subplots, --subplot and --slope-correction.
void add_sampling_options(CLI::App& command,
                          study::SamplingSettings& settings,
                          PlotsArgument& plots);

/// Adds --equations and --equation-file.
void add_equation_options(CLI::App& command, study::EquationSettings& settings);

/// Opens the table of plots, in the coordinates of the trees, if there is one.
void open_plots(const PlotsArgument& plots,
                const TreeTable& trees,
                const CommonOptions& common,
                study::SamplingSettings& settings);

/// Adds --neighbors, --alpha, --edge, --buffer, --window, --circle, --per, --dominance, --crowding,
/// --further, --competition-radius and --open-grown.
void add_unit_options(CLI::App& command, study::UnitSettings& settings);

/// Refuses --buffer, --competition-radius and --open-grown if no computed index depends on them.
/// \param further  the further indices that are computed
void refuse_idle_unit_options(const CLI::App& command,
                              const study::UnitSettings& settings,
                              const std::vector<stand::FurtherIndex>& further);

}  // namespace silvafit::cli
