// SPDX-License-Identifier: MIT
// Starts from a mixed-effects fit with interchangeable terms of the formula exchanged.
#pragma once

#include <string_view>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

inline constexpr std::string_view kExchangedOrigin = "a fit with exchanged terms";

/// A start from a fit with other coefficients of the same population curve: those that differ get
/// independent random effects that change the mean by a residual standard deviation.
MixedEffectsFit exchanged_fit(const NonlinearModel& model,
                              const MixedEffectsFit& fit,
                              const VectorXd& coefficients);

/// The fit with exchanged coefficients that give the same population curve. Without random effects
/// these are equal fits; with random effects on one of the terms they are different ones.
std::vector<MixedEffectsFit> exchanged_fits(const NonlinearModel& model,
                                            const MixedEffectsFit& fit);

}  // namespace silvafit::fit
