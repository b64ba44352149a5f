// SPDX-License-Identifier: MIT
// Means over random effects by quadrature.
#pragma once

#include "prediction/row_mean.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

struct MarginalMean {
  VectorXd value{};     ///< (N) E f(phi + A b), NaN if f is not defined around b = 0
  MatrixXd gradient{};  ///< (N x p) its derivative by the coefficients, if requested
  /// Largest relative difference of the last two rules of a row; infinite if it has only one.
  double difference = 0.0;
};

/// The mean of f over b ~ N(0, covariance) around given arguments, by product Gauss-Hermite rules
/// of growing size, until two of them agree. A row whose formula is not defined at the far nodes of
/// a rule keeps the mean by the rule before.
/// \param arguments   (N x K + U) at b = 0
/// \param covariance  (p x p) of the coefficients' random effects; may be singular
/// \param accuracy    relative difference of two rules that agree
MarginalMean marginal_mean(const RowMean& mean,
                           const MatrixXd& arguments,
                           const MatrixXd& covariance,
                           double accuracy,
                           bool with_gradient);

}  // namespace silvafit::fit
