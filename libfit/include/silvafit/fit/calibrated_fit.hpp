// SPDX-License-Identifier: MIT
// A fit with the random effects of other groups than those of its data.
#pragma once

#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// The fit with the groups of a calibration instead of its own, so that its conditional predictions
/// are calibrated ones. A group whose mode was not found is treated as unknown.
FittedModel with_groups(const FittedModel& fit, const Calibration& calibration);

}  // namespace silvafit::fit
