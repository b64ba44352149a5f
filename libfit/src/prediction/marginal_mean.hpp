// SPDX-License-Identifier: MIT
// Means over random effects by quadrature.
#pragma once

#include <Eigen/Core>

#include "prediction/row_mean.hpp"

namespace silvafit::fit {

struct MarginalMean {
  Eigen::VectorXd value{};     ///< (N) E f(phi + A b)
  Eigen::MatrixXd gradient{};  ///< (N x p) its derivative by the coefficients, if wanted
  double difference = 0.0;     ///< largest relative difference of the last two rules
};

/// The mean of f over b ~ N(0, covariance) around given arguments, by product Gauss-Hermite rules
/// of growing size, until two of them agree. \param arguments   (N x K + U) at b = 0 \param
/// covariance  (p x p) of the coefficients' random effects; may be singular \param accuracy
/// relative difference of two rules that agree
MarginalMean marginal_mean(const RowMean& mean,
                           const Eigen::MatrixXd& arguments,
                           const Eigen::MatrixXd& covariance,
                           double accuracy,
                           bool with_gradient);

}  // namespace silvafit::fit
