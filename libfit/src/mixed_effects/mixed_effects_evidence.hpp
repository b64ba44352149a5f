// SPDX-License-Identifier: MIT
// What the evidence of a mixed-effects fit means: rank, boundary and verdict.
#pragma once

#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// What the iterations of a method are: alternations of its two steps, or values of a likelihood.
enum class Rounds { kAlternations, kEvaluations };

/// Fills in names, labels and the degrees of freedom of the t tests.
void describe(const NonlinearModel& model, MixedEffectsFit& fit);

/// Fills in rank and boundary of a fit's convergence and puts its evidence into a sentence. A fit
/// whose data cannot tell coefficients or variance components apart has not converged, and such
/// coefficients have no standard errors.
/// \param is_restricted  whether the likelihood is the restricted one
void judge(const NonlinearModel& model,
           MixedEffectsFit& fit,
           Rounds rounds,
           bool is_restricted = false);

}  // namespace silvafit::fit
