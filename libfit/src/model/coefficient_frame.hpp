// SPDX-License-Identifier: MIT
// Coordinates of the coefficients in which the columns of the Jacobian are orthogonal.
#pragma once

#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Linear coordinates of the coefficients, beta = T x, and of random effects, b = U u. One unit of
/// each changes the mean by about the same amount, and nearly dependent columns of the Jacobian,
/// such as those of a constant and of a covariate with a large mean, are orthogonalized.
/// Results in these coordinates do not depend on the units of the data or on the origin of a
/// covariate.
struct CoefficientFrame {
  MatrixXd beta{};                  ///< (p x p) T, with a positive diagonal
  std::vector<MatrixXd> effects{};  ///< (q x q) U of each term, lower triangular
  /// Units of the coefficients with random effects only, of a shared frame.
  VectorXd random_only{};
  bool has_full_rank = true;  ///< whether no column of the Jacobian depends on those before it

  /// The units of all columns of a shared frame: the diagonal of T, then those with effects only.
  VectorXd units() const;
  /// (columns x columns) T with ones on its diagonal, for all columns; empty if T is diagonal.
  MatrixXd mixing() const;
};

/// The frame in which the columns of the Jacobian are orthogonal and have the given length.
/// Effects are only mixed within blocks whose covariance is free, and only if their columns are
/// nearly dependent: any other mixing would change the model.
/// If columns depend on those before them, their coordinates do not change the mean.
/// \param jacobian  (N x columns) of the mean by the coefficients, also those with random effects
///   only; a column that is not finite is omitted
/// \param length    positive
CoefficientFrame orthogonal_frame(const NonlinearModel& model, MatrixXd jacobian, double length);

/// The same for methods whose random effects act on columns of J T: T has U in its rows and columns
/// of the effects, so that not all columns are orthogonal. If no columns of the Jacobian are nearly
/// dependent, T is diagonal.
CoefficientFrame shared_frame(const NonlinearModel& model, MatrixXd jacobian, double length);

/// The frames at given coefficients, with the norm of the residuals there as the length: one unit
/// changes the mean by about one residual standard deviation.
CoefficientFrame frame_at(const NonlinearModel& model, const VectorXd& coefficients);
CoefficientFrame shared_frame_at(const NonlinearModel& model, const VectorXd& coefficients);

}  // namespace silvafit::fit
