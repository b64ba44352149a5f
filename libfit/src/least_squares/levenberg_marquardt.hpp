// SPDX-License-Identifier: MIT
// Levenberg-Marquardt descents over the nonlinear coefficients.
#pragma once

#include "least_squares/variable_projection.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

struct DescentOptions {
  int maximum_iterations = 500;
  /// Stops if an iteration decreases the sum of squares by less than this share.
  double tolerance = 1e-14;
  /// Index of a nonlinear coefficient that is held, -1 for none.
  int held = -1;
};

/// The lowest point of a descent.
struct Descent {
  VectorXd coefficients{};      ///< (p) all of them
  double sum_of_squares = 0.0;  ///< infinite if the start has no finite mean
  int iterations = 0;
};

/// Levenberg-Marquardt steps by ceres::TinySolver: damped by the diagonal of J'J, as in Marquardt
/// 1963, Journal of the Society for Industrial and Applied Mathematics 11, 431-441, by the rule of
/// Madsen, Nielsen and Tingleff 2004, Methods for non-linear least squares problems, section 3.2.
///
/// \param nonlinear  (q) where to start
Descent descend(ProjectedModel& model, const VectorXd& nonlinear, const DescentOptions& options);

}  // namespace silvafit::fit
