// SPDX-License-Identifier: MIT
// Mixed models whose likelihood has no maximum.
#pragma once

#include <string>

#include "model/coefficient_frame.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// Why the likelihood of a mixed model rises for ever, as a sentence with what to do; empty where
/// nothing shows that it does:
/// - The model goes through all observations, so that the residual variance goes to zero.
/// - A random effect has run to where the curve means nothing: at two standard deviations it is
///   beyond all measure of the response, or no longer depends on the effect on either side.
/// - A coefficient has a standard error far below what its random effect allows.
/// \param frame  of the coefficients at the estimates
std::string degeneracy(const NonlinearModel& model,
                       const CoefficientFrame& frame,
                       const MixedEffectsFit& fit);
/// Whether there is such a reason.
bool has_no_maximum(const NonlinearModel& model, const MixedEffectsFit& fit);

}  // namespace silvafit::fit
