// SPDX-License-Identifier: MIT
// Residuals of rows without a response, from those of measured rows of their group.
#pragma once

#include "silvafit/data/table.hpp"
#include "silvafit/fit/prediction.hpp"

namespace silvafit::fit {

/// Adds to the values of rows without a response the best linear prediction of their residuals, and
/// reduces their residual_sd accordingly. Rows without a time or position are not changed, nor is
/// anything if the order of the rows is their time.
/// \param result  with values and residual_sd of all rows
/// \throws InputError if a time or position is repeated in the measured rows of a group
/// Source: Cressie 1993, Statistics for Spatial Data, section 3.2 (simple kriging).
void add_neighbors(const FittedModel& fit, const data::Table& table, Prediction& result);

}  // namespace silvafit::fit
