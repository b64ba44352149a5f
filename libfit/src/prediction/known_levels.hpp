// SPDX-License-Identifier: MIT
// Values of factors that a fit has not seen.
#pragma once

#include <optional>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// The table with values missing where a factor of the model has one that the fit has not seen: it
/// has no coefficient, and the first level is no estimate of it. None where there are no such.
std::optional<data::Table> without_unknown_levels(const FittedModel& fit, const data::Table& table);

}  // namespace silvafit::fit
