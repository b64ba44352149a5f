// SPDX-License-Identifier: MIT
// Searches of a marginal likelihood from given fits.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>

#include "mixed_effects/mixed_effects_evidence.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// \throws UsageError without random effects, or if there are too many for quadrature
void check_marginal(const NonlinearModel& model,
                    Integration integration,
                    const MarginalOptions& options);

/// Limits of a search.
struct MarginalEffort {
  /// Whether it has all evaluations that a fit may have; otherwise it stops early where it makes
  /// no progress.
  bool is_complete = false;
  /// Log-likelihood of a known maximum: a search stops if it is below and its progress is too slow
  /// to reach it.
  double known = -std::numeric_limits<double>::infinity();
};

/// The maximum that one search from a fit leads to.
/// \returns a fit that is neither described nor judged; nothing where the likelihood does not hold,
///   or below a known maximum
/// \param obstacle  is filled in where the fit has not converged, unless null
std::optional<MixedEffectsFit> marginal_from(const NonlinearModel& model,
                                             const MixedEffectsFit& start,
                                             Integration integration,
                                             const MarginalOptions& options,
                                             const MarginalEffort& effort = {},
                                             Obstacle* obstacle = nullptr);

/// The same, described and judged.
/// \returns nothing if it does not converge
std::optional<MixedEffectsFit> refit_marginal(const NonlinearModel& model,
                                              const MixedEffectsFit& start,
                                              Integration integration,
                                              const MarginalOptions& options);

/// The log-likelihood at the estimates of a fit; NaN where it does not hold.
double marginal_log_likelihood(const NonlinearModel& model,
                               const MixedEffectsFit& fit,
                               Integration integration,
                               const MarginalOptions& options);

/// Fits from the end of Lindstrom and Bates' method and, if this does not converge, from the
/// maximum of the first-order method and the pooled fit.
/// \param pooled      (p) coefficients of the pooled fit
/// \param linearized  a described and judged fit by Lindstrom and Bates' method, converged or not
MixedEffectsFit fit_marginal_from(const NonlinearModel& model,
                                  const Eigen::VectorXd& pooled,
                                  const MixedEffectsFit& linearized,
                                  Integration integration,
                                  const MarginalOptions& options);

}  // namespace silvafit::fit
