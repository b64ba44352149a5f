// SPDX-License-Identifier: MIT
// Minimization of a smooth function of a few variables with exact gradients.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace silvafit::fit {

/// Value and, unless null, gradient of the function; a value that is not finite means "outside".
using SmoothFunction = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd* gradient)>;

struct QuasiNewtonResult {
  Eigen::VectorXd x{};
  double value = 0.0;
  Eigen::MatrixXd hessian{};  ///< positive definite approximation at x
  double decrement = 0.0;     ///< g' H^-1 g at x
  int evaluations = 0;
  bool is_blocked = false;  ///< whether it stopped because of short steps
};

struct QuasiNewtonOptions {
  double decrement = 1e-14;  ///< stop below this
  /// Stop below this as well if some steps have not halved the decrement: rounding of the function
  /// prevents it.
  double rounded_decrement = 0.0;
  int maximum_steps = 100;
  /// Stop after so many very short steps in a row, as at a jump of the function; 0 for never.
  int most_short_steps = 0;
  double longest_step = 2.0;  ///< per step, in any variable
  /// Whether the first Hessian comes from differences to one side: half as many gradients, and
  /// digits enough to start with.
  bool one_sided = false;
};

/// Newton steps whose Hessian starts as differences of the exact gradient (or as given) and is then
/// kept by BFGS updates; |eigenvalues| are floored, so that each direction descends; Armijo
/// halving.
/// \param hessian  start for the Hessian, empty to have it computed
QuasiNewtonResult minimize(const SmoothFunction& function,
                           const Eigen::VectorXd& start,
                           const Eigen::MatrixXd& hessian = {},
                           const QuasiNewtonOptions& options = {});

/// The Hessian from central differences of the exact gradient, symmetrized. Where the
/// function ends on one side of x, the difference is that to the other; where it ends on both, rows
/// and columns are NaN.
Eigen::MatrixXd hessian_from_gradients(const SmoothFunction& function, const Eigen::VectorXd& x);

/// The Hessian from differences of the exact gradient to one side, not symmetrized: its
/// asymmetry is a measure of its error. Where the function ends there, the other
/// side is taken; where it ends on both, the column is NaN.
/// \param gradient  at x
Eigen::MatrixXd one_sided_hessian(const SmoothFunction& function,
                                  const Eigen::VectorXd& x,
                                  const Eigen::VectorXd& gradient);

}  // namespace silvafit::fit
