// SPDX-License-Identifier: MIT
// The random effects of groups whose residuals are correlated, and their uncertainty: those of the
// penalized least squares of lb.
#pragma once

#include <vector>

#include "conditional_modes/effect_posteriors.hpp"

namespace silvafit::fit {

/// As find_effects(); effects of a cluster whose search does not converge are NaN.
std::vector<EffectPosterior> find_correlated_effects(const NonlinearModel& model,
                                                     const FittedModel& fit,
                                                     const EffectPriors& priors);

/// As describe_effects().
std::vector<EffectPosterior> describe_correlated_effects(const NonlinearModel& model,
                                                         const FittedModel& fit);

}  // namespace silvafit::fit
