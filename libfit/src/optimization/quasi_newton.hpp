// SPDX-License-Identifier: MIT
// Minimization of a smooth function of a few variables with exact gradients.
#pragma once

#include <functional>

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Value and, unless null, gradient of the function; not finite outside of its domain.
using SmoothFunction = std::function<double(const VectorXd& x, VectorXd* gradient)>;

struct QuasiNewtonResult {
  VectorXd x{};
  double value = 0.0;
  MatrixXd hessian{};      ///< positive definite approximation at x
  double decrement = 0.0;  ///< g' H^-1 g at x
  int evaluations = 0;
  bool is_blocked = false;  ///< whether it stopped because of short steps
};

struct QuasiNewtonOptions {
  double decrement = 1e-18;  ///< stop below this
  /// Stop below this as well if some steps have not halved the decrement: rounding of the function
  /// prevents it.
  double rounded_decrement = 1e-14;
  int maximum_steps = 100;
  /// Stop after this number of consecutive very short steps, as at a discontinuity; 0: never.
  int most_short_steps = 0;
  double longest_step = 2.0;  ///< per step, in any variable
  /// Whether the first Hessian is computed from one-sided differences: half as many gradients, and
  /// sufficient digits for a start.
  bool one_sided = false;
};

/// BFGS steps by ceres::GradientProblemSolver in the coordinates of the Cholesky factor of the
/// first Hessian, which is given or consists of differences of the exact gradient; |eigenvalues|
/// are floored, so that each direction descends. Newton steps follow where the value no longer
/// resolves a decrease. A search that ends elsewhere starts again with a new Hessian.
///
/// \param hessian  start for the Hessian; empty: it is computed
QuasiNewtonResult minimize(const SmoothFunction& function,
                           const VectorXd& start,
                           const MatrixXd& hessian = {},
                           const QuasiNewtonOptions& options = {});

/// The Hessian from central differences of the exact gradient, symmetrized. Where the gradient
/// changes differently to the two sides, the function is far from a parabola within the step, and
/// the step is shortened: the result is the curvature at x, which does not depend on coordinates.
/// If the function is undefined on one side of x, the one-sided difference to the other is used; if
/// it is undefined on both, rows and columns are NaN.
/// \param gradient  at x
MatrixXd hessian_from_gradients(const SmoothFunction& function,
                                const VectorXd& x,
                                const VectorXd& gradient);

/// The mean curvature within one standard error of x, 1/sqrt(H_ii) in each variable, or a tenth of
/// its unit if that is less. A likelihood by quadrature of a curve with a kink that random effects
/// move consists of pieces, between which its slope jumps; the curvature of the one piece at x
/// misses what the jumps contribute.
MatrixXd hessian_over_errors(const SmoothFunction& function,
                             const VectorXd& x,
                             const VectorXd& gradient);

/// The Hessian from one-sided differences of the exact gradient, not symmetrized: its asymmetry is
/// a measure of its error. If the function is undefined on this side, the other one is used; if it
/// is undefined on both, the column is NaN.
/// \param gradient  at x
MatrixXd one_sided_hessian(const SmoothFunction& function,
                           const VectorXd& x,
                           const VectorXd& gradient);

}  // namespace silvafit::fit
