// SPDX-License-Identifier: MIT
// The number of digits of predictions.
#pragma once

#include "command.hpp"

namespace silvafit::cli {

/// Significant digits of predictions in CSV files: a height to a tenth of a millimeter, far below
/// any prediction's error.
inline constexpr int kPredictedDigits = 6;

/// Adds --digits.
void add_digits_option(CLI::App& command, int& digits);

}  // namespace silvafit::cli
