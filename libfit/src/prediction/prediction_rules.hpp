// SPDX-License-Identifier: MIT
// Quadrature points for predictions over the errors of their arguments.
#pragma once

#include "conditional_modes/quadrature_rule.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Points in the main direction, by how much the mean changes in it against the residual.
enum class MainPoints { kFew, kDense, kGapless };

/// Quadrature points over the errors of the arguments.
struct PredictionRule {
  QuadratureRule points{};
  Index stride = 0;  ///< of close_gaps, which the components then need; else 0
};

/// \param steepness  largest change of the mean per standard deviation of the main direction, in
///   residual standard deviations
MainPoints points_for(double steepness);

/// Points are a product of rules of one variable in the main direction and up to three others; more
/// others share 500 points, however many they are.
/// \param width  directions, of which the first is the main one
/// \param many   whether the others need many points
PredictionRule prediction_rule(Index width, MainPoints main, bool many);

/// R with R R' a covariance, without columns of zeros.
MatrixXd root_without_zeros(const MatrixXd& covariance);

/// A root of the same covariance whose first column points where the mean changes most; the mean
/// does not change in the others, to first order.
/// \param root   of root_without_zeros()
/// \param slope  gradient of the mean
MatrixXd rotated_root(MatrixXd root, const VectorXd& slope);

}  // namespace silvafit::fit
