// SPDX-License-Identifier: MIT
// The exact Hessian of a sum of squares.
#pragma once

#include <Eigen/Core>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// (p x p) the Hessian of half the sum of squared residuals, J'J - sum r f'', with symbolic second
/// derivatives of the mean. The Gauss-Newton approximation omits the second term.
/// \param coefficients  (p) the same for all groups
Eigen::MatrixXd least_squares_hessian(const NonlinearModel& model,
                                      const Eigen::VectorXd& coefficients);

}  // namespace silvafit::fit
