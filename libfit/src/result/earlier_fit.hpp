// SPDX-License-Identifier: MIT
// An earlier fit as the start of a fit of the same model to the same or other data.
#pragma once

#include <optional>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The start of a model and its groups from an earlier fit.
///
/// Coefficients, strata and groups are found by name; unknown groups have effects of zero, unknown
/// strata a typical parameter. A variance function after a constant variance has its usual start.
/// \returns no value if the earlier fit lacks a coefficient, has other random effects or another
///   variance function that is not constant, or failed
std::optional<MixedEffectsFit> as_start(const FittedModel& earlier, const NonlinearModel& model);

/// A variance function's estimate with its sigma.
struct ResidualVariance {
  VarianceEstimate variance{};
  double sigma = 0.0;
};

/// The residual variance of estimates in the strata of a model, whose reference stratum may differ
/// from that of the estimates; unknown strata have a typical parameter.
ResidualVariance residual_variance_for(const Estimates& estimates, const NonlinearModel& model);

}  // namespace silvafit::fit
