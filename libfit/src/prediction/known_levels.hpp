// SPDX-License-Identifier: MIT
// Values of factors that are not in the data of a fit.
#pragma once

#include <optional>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// The table with missing values for levels of factors that the fit does not have: they have no
/// coefficient, and the first level is not an estimate of them. None if there are no such levels.
std::optional<data::Table> without_unknown_levels(const FittedModel& fit, const data::Table& table);

}  // namespace silvafit::fit
