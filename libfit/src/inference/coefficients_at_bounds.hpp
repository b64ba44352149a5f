// SPDX-License-Identifier: MIT
// Which coefficients of a fit ended at a bound.
#pragma once

#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Whether the estimate of a coefficient is at its bound. It counts as a parameter of the fit, but
/// has no variance.
bool is_at_bound(const FittedModel& fit, const std::string& coefficient);

/// Parameters of a fit as if coefficients at their bounds had been held there.
int count_without_bounded(const FittedModel& fit);

}  // namespace silvafit::fit
