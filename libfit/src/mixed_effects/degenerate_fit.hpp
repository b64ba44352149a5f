// SPDX-License-Identifier: MIT
// Mixed models whose likelihood has no maximum.
#pragma once

#include <string>
#include <vector>

#include "model/coefficient_frame.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// Why a mixed model has no maximum that can be used.
struct Degeneracy {
  ConvergenceStatus status = ConvergenceStatus::kNoMaximum;
  std::vector<Evidence> evidence{};
  std::string text{};     ///< a sentence with the remedy; empty without a sign of degeneracy
  bool is_exact = false;  ///< whether the model goes through all observations
};

/// Whether the likelihood of a mixed model is unbounded, or nearly so:
/// - The model goes through all observations, so that the residual variance goes to zero.
/// - The standard deviation of a random effect grows without bound: at two standard deviations the
///   curve is far beyond the response, or it no longer depends on the effect on either side.
/// - A coefficient has a standard error far below what its random effect allows.
/// \param frame  of the coefficients at the estimates
Degeneracy degeneracy(const NonlinearModel& model,
                      const CoefficientFrame& frame,
                      const MixedEffectsFit& fit);
/// Whether there is such a reason.
bool has_no_maximum(const NonlinearModel& model, const MixedEffectsFit& fit);

}  // namespace silvafit::fit
