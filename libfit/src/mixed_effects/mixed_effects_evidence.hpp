// SPDX-License-Identifier: MIT
// What the evidence of a mixed-effects fit means: rank, boundary and verdict.
#pragma once

#include <string>
#include <string_view>

#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// What a search that ended short of an optimum knows of it.
struct Obstacle {
  ConvergenceStatus status = ConvergenceStatus::kMaximumNotReached;
  std::string text{};    ///< what stood in its way, as a clause; empty where it is not known
  std::string moving{};  ///< the parameter that would still move most, "sd(b)"
};

/// What stands in the way of a search of a likelihood that has the curvature at the modes in it.
inline constexpr std::string_view kNoClearMode =
    "the likelihood increases towards points where the conditional density of a group's random "
    "effects is flat at its mode and the approximation is not valid";

/// What the iterations of a method are: alternations of its two steps, or values of a likelihood.
enum class Rounds { kAlternations, kEvaluations };

/// Whether a search has ended where the mean hardly depends on coefficients that it depends on
/// elsewhere. A likelihood is flat there, which looks like a maximum.
bool has_diverged(const NonlinearModel& model, const MixedEffectsFit& fit);

/// Fills in names, labels and the degrees of freedom of the t tests.
void describe(const NonlinearModel& model, MixedEffectsFit& fit);

/// Fills in rank and boundary of a fit's convergence and puts its evidence into a sentence. A fit
/// with coefficients or variance components that are not identifiable has not converged, and such
/// coefficients have no standard errors.
/// \param is_restricted  whether the likelihood is the restricted one
/// \param obstacle       of a fit that has not converged
void judge(const NonlinearModel& model,
           MixedEffectsFit& fit,
           Rounds rounds,
           bool is_restricted = false,
           const Obstacle& obstacle = {});

}  // namespace silvafit::fit
