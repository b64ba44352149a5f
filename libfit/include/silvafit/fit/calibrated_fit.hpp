// SPDX-License-Identifier: MIT
// A fit that knows other groups than those it was fitted to.
#pragma once

#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// The fit with the groups of a calibration in place of its own, so that its conditional
/// predictions are calibrated ones. A group whose mode was not found counts as never seen.
FittedModel with_groups(const FittedModel& fit, const Calibration& calibration);

}  // namespace silvafit::fit
