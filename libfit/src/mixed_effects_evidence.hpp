// SPDX-License-Identifier: MIT
// What the evidence of a mixed-effects fit means: rank, boundary and verdict.
#pragma once

#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// Fills in rank and boundary of a fit's convergence and puts its evidence into a sentence.
void judge(const NonlinearModel& model, MixedEffectsFit& fit);

}  // namespace silvafit::fit
