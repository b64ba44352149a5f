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
