// SPDX-License-Identifier: MIT
// Searches of a marginal likelihood from given fits.
#pragma once

#include <optional>

#include "mixed_effects/mixed_effects_evidence.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// \throws UsageError without random effects, or if there are too many for quadrature
void check_marginal(const NonlinearModel& model, Method method, const MixedEffectsOptions& options);

/// The extent of a search.
struct MarginalEffort {
  /// Whether all evaluations of a fit are allowed; otherwise the search stops early without
  /// progress.
  bool is_complete = false;
  /// Log-likelihood of a known maximum: a search stops if it is below and its progress is too slow
  /// to reach it.
  double known = -kInfinity;
};

/// The end of a search.
struct MarginalEnd {
  /// Without standard errors and message; no value if the likelihood is not valid, or the maximum
  /// is below a known one.
  std::optional<MixedEffectsFit> fit{};
  Obstacle obstacle{};  ///< of a fit that has not converged
  int evaluations = 0;
};

/// The maximum of one search from a fit.
MarginalEnd marginal_from(const NonlinearModel& model,
                          const MixedEffectsFit& start,
                          Method method,
                          const MixedEffectsOptions& options,
                          const MarginalEffort& effort = {});

/// The maximum of a short search from coefficients with random effects of several spreads.
/// \param coefficients  (p)
MarginalEnd marginal_from_coefficients(const NonlinearModel& model,
                                       const VectorXd& coefficients,
                                       Method method,
                                       const MixedEffectsOptions& options,
                                       const MarginalEffort& effort = {});

/// The maximum of one search from a fit, with standard errors and convergence message.
/// \returns no value if it does not converge
std::optional<MixedEffectsFit> refit_marginal(const NonlinearModel& model,
                                              const MixedEffectsFit& start,
                                              Method method,
                                              const MixedEffectsOptions& options);

/// Computes the covariance of the coefficients of a converged fit anew, in units of its estimates.
/// At a kink it stays that of one side, which the search has found.
void compute_errors(const NonlinearModel& model,
                    Method method,
                    const MixedEffectsOptions& options,
                    MixedEffectsFit& fit);

/// The log-likelihood at the estimates of a fit; NaN if it is not valid there.
double marginal_log_likelihood(const NonlinearModel& model,
                               const MixedEffectsFit& fit,
                               Method method,
                               const MixedEffectsOptions& options);

/// Fits from the end of Lindstrom and Bates' method and, if this does not converge, from the
/// maximum of the first-order method and the pooled fit.
/// \param pooled      (p) coefficients of the pooled fit
/// \param linearized  a complete fit by Lindstrom and Bates' method, converged or not
MixedEffectsFit fit_marginal_from(const NonlinearModel& model,
                                  const VectorXd& pooled,
                                  const MixedEffectsFit& linearized,
                                  Method method,
                                  const MixedEffectsOptions& options);

}  // namespace silvafit::fit
