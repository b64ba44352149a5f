// SPDX-License-Identifier: MIT
// Doubts about what the user wrote, at the beginning of the convergence message.
#pragma once

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Adds to the convergence message of a fit, before what it says, names that were taken as
/// parameters and may be misspelt columns. A fit that failed lists all names that were taken as
/// parameters. Nothing is added to models that are not from texts of a user.
void add_name_doubts(const FitModelOptions& options, FittedModel& fit);

/// The same, and the doubts about a response whose values are not those of a normal distribution,
/// and about columns whose only negative value is -9, -99 or -999.
void add_doubts(const data::Table& table, const FitModelOptions& options, FitResult& result);

}  // namespace silvafit::fit
