// SPDX-License-Identifier: MIT
// Marginal and conditional R2 of mixed models.
#pragma once

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

struct VarianceShares {
  double marginal = 0.0;
  double conditional = 0.0;
};

/// Shares of the variance of an observation that fixed effects, and fixed and random effects,
/// explain: s_f / (s_f + s_b + s_e) and (s_f + s_b) / (s_f + s_b + s_e).
///
/// s_f is the variance of f(beta) among the rows (divisor N - 1), s_b the mean of the rows' Z Psi
/// Z' of all groupings, Z the slopes of f at b = 0, and s_e the mean of (sigma g)^2. For a linear
/// model with random intercepts this is Nakagawa and Schielzeth's, with random slopes Johnson's.
/// \param residual_sd  (N) sigma g
/// Source: Nakagawa and Schielzeth 2013, Methods in Ecology and Evolution 4, 133-142; Johnson 2014,
/// Methods in Ecology and Evolution 5, 944-946.
VarianceShares variance_shares(const FittedModel& fit,
                               const NonlinearModel& model,
                               const VectorXd& residual_sd);

/// (N) Z Psi Z' of each row, summed over the groupings.
/// \param slopes  (N x p)
VectorXd variance_of_effects(const FittedModel& fit,
                             const NonlinearModel& model,
                             const MatrixXd& slopes);

}  // namespace silvafit::fit
