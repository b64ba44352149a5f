// SPDX-License-Identifier: MIT
// The last digits of a least-squares solution, and the evidence that it is one.
#pragma once

#include <optional>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// A point and the properties of the sum of squares around it. s^2 is SSE/(n - p).
struct NewtonPoint {
  VectorXd coefficients{};  ///< (p)
  VectorXd mean{};          ///< (N)
  double sum_of_squares = 0.0;
  bool finite = true;  ///< false where the Jacobian is not
  int iterations = 0;
  /// g' H^-1 g / s^2 with the Hessian H of half the sum of squares (J'J where H is not positive
  /// definite): the squared distance to the optimum in standard errors.
  double decrement = 0.0;
  /// The part of the decrement that may be due to rounding alone.
  double rounding = 0.0;
  /// H is positive definite, so that the point is a minimum.
  bool positive_curvature = false;
  int rank = 0;
  /// Coefficients that are not identifiable; none if there is no Jacobian.
  std::vector<Index> confounded{};
  /// (p x p) (J'J)^-1, NaN in the rows and columns of confounded coefficients.
  MatrixXd unscaled_covariance{};
  /// Coefficients in which the sum of squares has a kink at the point.
  std::vector<Index> kinked{};
};

/// Newton steps from a point near the optimum, as long as they are improvements.
NewtonPoint refine(const NonlinearModel& model, const VectorXd& coefficients);

/// The same without a step.
NewtonPoint evidence_at(const NonlinearModel& model, const Eigen::VectorXd& coefficients);

/// The minimum at kinks of the formula where a search for a smooth one is stuck; no value if there
/// is none. Its covariance is (J'J)^-1 on one side of the kinks: estimates of kinked curves are
/// asymptotically normal with it if the curve is continuous.
/// Source: Feder 1975, Annals of Statistics 3: 49-83.
std::optional<NewtonPoint> minimum_at_kinks(const NonlinearModel& model, const NewtonPoint& stuck);

/// True at a minimum, to 1e-5 standard errors or to rounding.
bool is_converged(const NewtonPoint& point);

/// Number of columns that are not sums of others.
Index numerical_rank(const MatrixXd& jacobian);

}  // namespace silvafit::fit
