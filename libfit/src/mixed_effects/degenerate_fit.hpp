// SPDX-License-Identifier: MIT
// Mixed models whose likelihood has no maximum.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/coefficient_frame.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The reason why a mixed model has no usable maximum.
struct Degeneracy {
  ConvergenceStatus status = ConvergenceStatus::kNoMaximum;
  std::vector<Evidence> evidence{};
  std::optional<Finding> reason{};  ///< none without degeneracy
  bool is_exact = false;            ///< whether the model fits all observations exactly
};

/// Whether the likelihood of a mixed model is unbounded, or nearly so:
/// - The model fits all observations exactly, so that the residual variance goes to zero.
/// - The standard deviation of a random effect grows without bound: at two standard deviations the
///   curve is far beyond the response, or it no longer depends on the effect on either side.
/// - A coefficient has a standard error far below what its random effect allows.
/// \param frame  of the coefficients at the estimates
Degeneracy degeneracy(const NonlinearModel& model,
                      const CoefficientFrame& frame,
                      const MixedEffectsFit& fit);
/// The random effects with which a curve passes through the observations of a stratum.
enum class PassingEffects {
  kAll,   ///< those of all terms, as the fit has them
  kSome,  ///< none, or those of the first terms; the others may be 0
};

/// Strata of a variance function through whose observations curve and random effects can pass,
/// although the effects alone cannot: the likelihood grows without bound as they do so and the
/// stratum's standard deviation goes to 0, so that an estimate is a local maximum at best. (The
/// restricted likelihood is bounded.)
std::vector<std::string> strata_without_freedom(const NonlinearModel& model,
                                                const MixedEffectsFit& fit,
                                                PassingEffects effects);
/// Whether the model fits all observations exactly.
bool fits_exactly(const NonlinearModel& model, const MixedEffectsFit& fit);
/// Whether there is a reason as in degeneracy().
/// \param fit  with the names of its effects, which describe() sets
bool has_no_maximum(const NonlinearModel& model, const MixedEffectsFit& fit);

}  // namespace silvafit::fit
