// SPDX-License-Identifier: MIT
// Standard errors and intervals of predictions.
#pragma once

#include "prediction/coefficient_sets.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/prediction.hpp"

namespace silvafit::fit {

/// Fills in errors, degrees of freedom and, if required, the limits of intervals.
/// \param values  the predictions so far: values and residual standard deviations
/// \param marginal_gradients  (N x p) derivatives of marginal means; rows that have none are not
///   read
void add_errors(const FittedModel& fit,
                const data::Table& table,
                const CoefficientSets& sets,
                const PredictionOptions& options,
                const MatrixXd& marginal_gradients,
                Prediction& values);

}  // namespace silvafit::fit
