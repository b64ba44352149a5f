// SPDX-License-Identifier: MIT
// Quantiles of values whose mean depends on arguments that are not known exactly.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Rows for whose value f(x) + s e quantiles are needed; the arguments x, parameters by row and
/// uncertain columns as RowMean has them, are normal around a center.
struct UnknownValues {
  const FittedModel& fit;
  const data::Table& table;                   ///< N rows
  const std::vector<std::string>& uncertain;  ///< U columns that are not known exactly
  MatrixXd arguments{};                       ///< (N x K + U) the center
  VectorXd value{};                           ///< (N) the mean there, finite
  MatrixXd gradient{};                        ///< (N x K + U) of the mean there
  VectorXd error{};               ///< (N) standard deviation of the value, to first order
  std::vector<MatrixXd> roots{};  ///< (N) R with R R' the covariance, by rotated_root()
};

/// (N x 2) the values that are exceeded from below and above with the probability `tail`; NaN where
/// the mean or s is not finite anywhere.
MatrixXd value_quantiles(const UnknownValues& rows, double tail);

}  // namespace silvafit::fit
