// SPDX-License-Identifier: MIT
// Options of the commands that predict.
#pragma once

#include "command.hpp"
#include "silvafit/study/predict_table.hpp"

namespace silvafit::cli {

/// Adds --level, --new-groups, --seen-groups, --interval, --interval-kind, --standard-errors and
/// --role.
void add_prediction_options(CLI::App& command, study::PredictionSettings& settings);

/// Refuses those options that have no effect.
void refuse_idle_prediction_options(const CLI::App& command,
                                    const study::PredictionSettings& settings);

}  // namespace silvafit::cli
