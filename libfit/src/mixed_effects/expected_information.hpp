// SPDX-License-Identifier: MIT
// The expected information on the fixed effects at the estimates of a mixed model.
#pragma once

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (p x p) covariance of the fixed effects, the inverse of sum_g J_g' V_g^-1 J_g with the Jacobian
/// J_g and V_g = Z_g Psi Z_g' + R_g of the model that is linear around given coefficients.
///
/// It needs first derivatives only, which are exact. Differences of gradients are not accurate
/// where a coefficient is hardly identifiable, because one standard error changes the curve far
/// beyond its linear approximation. Orthogonal triangles instead of cross products keep
/// directions whose effect on the mean is 1e-8 of that of their coefficients.
/// \param coefficients  the fixed effects, or (columns x G) those of each group; with those that
///   have random effects only
/// \param residual_sd   (N) of each observation
/// \param frame         (p x p) T with orthogonal columns J T
/// \return  NaN where the Jacobian or an estimate is not finite; infinite where it has no full rank
/// Source: Pinheiro and Bates 2000, section 7.2.1; the elimination of b in section 2.2.3.
MatrixXd expected_covariance(const NonlinearModel& model,
                             const Estimates& fit,
                             const Eigen::Ref<const MatrixXd>& coefficients,
                             const VectorXd& residual_sd,
                             const MatrixXd& frame);

/// nlme's factor N / (N - p) of the covariance by lb and gnls with maximum likelihood.
double likelihood_factor(const NonlinearModel& model);

}  // namespace silvafit::fit
