// SPDX-License-Identifier: MIT
// Which coefficients of a fit ended at a bound.
#pragma once

#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Whether a coefficient is where a bound has stopped it. It counts as a parameter of its fit, but
/// has no variance.
bool is_at_bound(const FittedModel& fit, const std::string& coefficient);

/// Parameters of a fit as if coefficients at their bounds had been held there.
int count_without_bounded(const FittedModel& fit);

}  // namespace silvafit::fit
