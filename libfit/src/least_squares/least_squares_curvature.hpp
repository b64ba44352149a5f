// SPDX-License-Identifier: MIT
// The exact Hessian of a sum of squares, from symbolic second derivatives of the mean.
#pragma once

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (p x p) the sum of r f'' over the observations, which the Gauss-Newton approximation of the
/// Hessian omits.
/// \param coefficients  (p) the same for all groups
/// \param residuals     (N) r
MatrixXd residual_curvature(const NonlinearModel& model,
                            const VectorXd& coefficients,
                            const VectorXd& residuals);

/// (p x p) the Hessian of half the sum of squared residuals, J'J - sum r f''.
/// \param coefficients  (p) the same for all groups
MatrixXd least_squares_hessian(const NonlinearModel& model, const VectorXd& coefficients);

}  // namespace silvafit::fit
