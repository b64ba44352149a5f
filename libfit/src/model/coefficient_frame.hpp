// SPDX-License-Identifier: MIT
// Coordinates of the coefficients in which the columns of the Jacobian are at right angles.
#pragma once

#include <Eigen/Core>

#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Linear coordinates of the coefficients, beta = T x, and of random effects, b = U u. One unit of
/// each moves the mean by about the same amount, and columns of the Jacobian that nearly depend on
/// each other, such as those of a constant and of a covariate with a large mean, are taken apart.
/// What is computed in these coordinates does not depend on the units of the data or on the origin
/// of a covariate.
struct CoefficientFrame {
  Eigen::MatrixXd beta{};     ///< (p x p) T, with a positive diagonal
  Eigen::MatrixXd outer{};    ///< (s x s) U of the coarser grouping, lower triangular
  Eigen::MatrixXd inner{};    ///< (q x q) U of the only or the finer grouping, lower triangular
  bool has_full_rank = true;  ///< whether no column of the Jacobian depends on those before it

  const Eigen::MatrixXd& effects(bool is_outer) const { return is_outer ? outer : inner; }
};

/// The frame in which the columns of the Jacobian are at right angles and have the given length.
/// Effects are only mixed within blocks whose covariance is free, and only where their columns
/// nearly depend on each other: any other mixing would change the model.
/// Where columns depend on those before them, units of those coordinates do not move the mean.
/// \param jacobian  (N x p) of the mean by the coefficients; a column that is not finite is omitted
/// \param length    positive
CoefficientFrame orthogonal_frame(const NonlinearModel& model,
                                  Eigen::MatrixXd jacobian,
                                  double length);

/// The same for methods whose random effects act on columns of J T: T has U in its rows and columns
/// of the effects, so that not all columns need be at right angles. Where no columns of the
/// Jacobian nearly depend on each other, T is diagonal.
CoefficientFrame shared_frame(const NonlinearModel& model, Eigen::MatrixXd jacobian, double length);

/// The frames at given coefficients, with the norm of the residuals there as the length: one unit
/// moves the mean by about one residual standard deviation.
CoefficientFrame frame_at(const NonlinearModel& model, const Eigen::VectorXd& coefficients);
CoefficientFrame shared_frame_at(const NonlinearModel& model, const Eigen::VectorXd& coefficients);

}  // namespace silvafit::fit
