// SPDX-License-Identifier: MIT
// Options of the commands that predict.
#pragma once

#include "command.hpp"
#include "silvafit/study/predict_table.hpp"

namespace silvafit::cli {

/// Significant digits of predictions in CSV files: a height to a tenth of a millimeter, far below
/// any prediction's error.
inline constexpr int kPredictedDigits = 6;

/// Adds --digits.
void add_digits_option(CLI::App& command, int& digits);

/// Adds the options of predictions.
void add_prediction_options(CLI::App& command, study::PredictionSettings& settings);

/// Refuses those options that have no effect.
void refuse_idle_prediction_options(const CLI::App& command,
                                    const study::PredictionSettings& settings);

}  // namespace silvafit::cli
