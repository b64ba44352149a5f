// SPDX-License-Identifier: MIT
// Options that several commands share: tables, structural units, sampling, predictions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "command.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/grow.hpp"
#include "silvafit/study/predict_table.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "silvafit/study/unit_settings.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {

/// Significant digits of predictions in CSV files: a height to a tenth of a millimeter, far below
/// any prediction's error.
inline constexpr int kPredictedDigits = 6;

/// Adds --digits.
void add_digits_option(CLI::App& command, int& digits);

/// Adds the options of predictions.
void add_prediction_options(CLI::App& command, study::PredictionSettings& settings);

/// Adds the options of reading a table of trees.
/// \param only  the keys of those that the command uses; empty: all
void add_reading_options(CLI::App& command,
                         study::ReadingSettings& settings,
                         std::vector<std::string_view> only = {});

/// Adds INVENTORY, its layer and all options of reading.
void add_inventory_options(CLI::App& command,
                           std::string& inventory,
                           study::ReadingSettings& settings,
                           TableArguments& table);

/// Adds the options of sampled plots, --plots-layer and --plots-sql.
void add_sampling_options(CLI::App& command,
                          study::SamplingSettings& settings,
                          source::TableChoice& plots);

/// Adds --equations and --equation-file.
void add_equation_options(CLI::App& command, study::EquationSettings& settings);

/// Opens the table of plots, in the coordinates of the trees, if there is one.
void open_plots(const source::TableChoice& choice,
                const TreeTable& trees,
                const CommonOptions& common,
                study::SamplingSettings& settings);

/// Adds the options of growing, except the common ones.
/// \param file, options  are filled when the command line is parsed
void add_grow_options(CLI::App& command, std::string& file, study::GrowSettings& options);

/// Adds the options of structural units.
void add_unit_options(CLI::App& command, study::UnitSettings& settings);

}  // namespace silvafit::cli
