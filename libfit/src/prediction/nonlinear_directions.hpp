// SPDX-License-Identifier: MIT
// The directions of its arguments in which a mean is nonlinear, and those in which it is linear.
#pragma once

#include <vector>

#include "prediction/row_mean.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Changes of the mean that are treated as rounding, in standard deviations of what is predicted:
/// far below the error of quadratures, and above that of derivatives of large canceling terms.
inline constexpr double kStraight = 1e-7;

/// (N) whether the mean of each row is a function of one linear combination of its arguments: in
/// the columns of its root behind the first it does not change, at any distance.
/// \param mean       of some rows
/// \param center     (N x K + U) their arguments
/// \param roots      (N) R with R R' the covariance of the arguments, as rotated_root() has it
/// \param tolerance  (N) changes of the mean that do not count
std::vector<bool> follow_one_combination(const RowMean& mean,
                                         const MatrixXd& center,
                                         const std::vector<MatrixXd>& roots,
                                         const VectorXd& tolerance);

/// The errors of a row's arguments, in independent standard normal variables u and t: the arguments
/// are center + root u, and the mean is f(center + root u) + linear t.
///
/// If the gradient, apart from a constant part, is in the same subspace at all points, the function
/// is nonlinear in that subspace only. The linear part has a normal distribution and needs no
/// quadrature points.
struct NonlinearDirections {
  MatrixXd root{};      ///< (K + U x q) q directions, the mean changes most along the first
  double linear = 0.0;  ///< standard deviation of the linear part
};

/// The number of points at which nonlinear_directions() takes gradients, each of q numbers a row.
Index probe_count(Index width);

/// \param mean       of some rows
/// \param center     (N x K + U) their arguments
/// \param gradient   (N x K + U) of the mean there
/// \param roots      (N) R with R R' the covariance of the arguments, as rotated_root() has it
/// \param tolerance  (N) changes of the mean that do not count
/// \param split      whether linear directions are omitted; otherwise only directions that do not
///   change the mean are: if the residual standard deviation depends on the mean, the linear part
///   has no normal distribution
/// \returns (N)
std::vector<NonlinearDirections> nonlinear_directions(const RowMean& mean,
                                                      const MatrixXd& center,
                                                      const MatrixXd& gradient,
                                                      const std::vector<MatrixXd>& roots,
                                                      const VectorXd& tolerance,
                                                      bool split);

}  // namespace silvafit::fit
