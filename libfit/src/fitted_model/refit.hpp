// SPDX-License-Identifier: MIT
// Fits that start from an earlier fit of the same model, perhaps to other data.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "model/variance_weights.hpp"
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

/// The fit of Lindstrom and Bates' method (or gnls) that one run from a start leads to.
/// \returns nothing if it does not converge
std::optional<MixedEffectsFit> refit_lindstrom_bates(const NonlinearModel& model,
                                                     const MixedEffectsFit& start,
                                                     const MixedEffectsOptions& options);

/// The same of a marginal likelihood.
std::optional<MixedEffectsFit> refit_marginal(const NonlinearModel& model,
                                              const MixedEffectsFit& start,
                                              Integration integration,
                                              const MarginalOptions& options);

/// Internal variance parameters of an estimate, moved inside the range if they are at its boundary:
/// there the likelihood is flat by symmetry, and a search would not leave it.
Eigen::VectorXd inside_range(const VarianceModel& variance, const VarianceEstimate& estimate);

}  // namespace silvafit::fit
