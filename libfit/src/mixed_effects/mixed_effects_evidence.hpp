// SPDX-License-Identifier: MIT
// The evaluation of a mixed-effects fit: rank, boundary and findings.
#pragma once

#include <optional>
#include <string>

#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The findings of a search that did not reach an optimum.
struct Obstacle {
  ConvergenceStatus status = ConvergenceStatus::kMaximumNotReached;
  std::optional<Finding::Kind> cause{};  ///< not known without one
  std::string moving{};                  ///< the parameter with the largest further change, "sd(b)"
};

/// The unit of iterations of a method: alternations of its two steps, or values of a likelihood.
enum class Rounds { kAlternations, kEvaluations };

/// Whether a search has ended at a point where the mean hardly depends on coefficients that are
/// identifiable elsewhere. The likelihood is flat there, so that the point seems to be a maximum.
bool has_diverged(const NonlinearModel& model, const MixedEffectsFit& fit);

/// Whether a fit has ended at a range of its correlation that is without bound.
bool has_unbounded_range(const NonlinearModel& model, const MixedEffectsFit& fit);
/// Records that the likelihood is higher with a range without bound.
/// \param log_likelihood  there
void note_unbounded_range(double log_likelihood, MixedEffectsFit& fit);
/// Whether a power of its variance function is larger without bound, for the observations with one
/// value only.
bool has_unbounded_power(const NonlinearModel& model, const MixedEffectsFit& fit);
/// The log-likelihood by which the ends of searches are compared: a range or power without bound is
/// the answer only if the likelihood is far higher there.
double compared(double log_likelihood, bool is_unbounded);

/// Sets names, labels and the degrees of freedom of the t tests.
void describe(const NonlinearModel& model, MixedEffectsFit& fit);

/// Sets rank, boundary and findings of a fit's convergence. A fit with
/// coefficients or variance components that are not identifiable has not converged, and such
/// coefficients have no standard errors.
/// \param is_restricted  whether the likelihood is the restricted one
/// \param obstacle       of a fit that has not converged
void judge(const NonlinearModel& model,
           MixedEffectsFit& fit,
           Rounds rounds,
           bool is_restricted = false,
           const Obstacle& obstacle = {});

}  // namespace silvafit::fit
