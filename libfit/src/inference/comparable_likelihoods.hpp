// SPDX-License-Identifier: MIT
// Whether the likelihoods of two fits can be compared, and how many parameters count.
#pragma once

#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Whether the estimate of a coefficient is at its bound. It counts as a parameter of the fit, but
/// has no variance.
bool is_at_bound(const FittedModel& fit, const std::string& coefficient);

/// Parameters of a fit as if coefficients at their bounds had been held there.
int count_without_bounded(const FittedModel& fit);

/// Whether a fit has converged to a finite log-likelihood.
bool has_usable_likelihood(const FittedModel& fit);

/// Why the likelihoods of two fits cannot be compared, in words; empty if they can: the fits are to
/// the same observations, by the same approximation of the likelihood, and if it is restricted,
/// with the same fixed effects.
std::string obstacle_to_comparing(const FittedModel& a, const FittedModel& b);

}  // namespace silvafit::fit
