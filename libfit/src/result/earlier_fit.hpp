// SPDX-License-Identifier: MIT
// An earlier fit as the start of one of the same model, perhaps to other data.
#pragma once

#include <optional>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The start of a model and its groups from an earlier fit.
///
/// Coefficients, strata and groups are found by name; groups that the earlier fit has not seen have
/// effects of zero, strata a typical parameter.
/// \returns nothing if the earlier fit has no value of a coefficient, other random effects or
///   another variance function, or failed
std::optional<MixedEffectsFit> as_start(const FittedModel& earlier, const NonlinearModel& model);

}  // namespace silvafit::fit
