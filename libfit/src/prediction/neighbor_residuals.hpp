// SPDX-License-Identifier: MIT
// Residuals of rows without a response, from those of measured rows of their group.
#pragma once

#include <vector>

#include "prediction/coefficient_sets.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/prediction.hpp"

namespace silvafit::fit {

/// The measured rows from which a row takes its residual.
struct Neighbors {
  Eigen::Index row = 0;
  std::vector<Eigen::Index> measured{};
  Eigen::VectorXd weights{};  ///< of their residuals in the prediction
};

/// Why a number of rows of one group cannot have the correlation of a fit, empty if they can: with
/// a negative correlation of all pairs, a sum of so many would have a negative variance.
std::string group_gap(const CorrelationEstimate& estimate, Index rows);

/// Adds to the values of rows without a response the best linear prediction of their residuals, and
/// reduces their residual_sd accordingly. Rows without a time or position are not changed, nor is
/// anything if the order of the rows is their time.
/// \param result  with values and residual_sd of all rows
/// \returns for each row that was changed
/// \throws InputError if a time or position is repeated in the measured rows of a group
/// Source: Cressie 1993, Statistics for Spatial Data, section 3.2 (simple kriging).
std::vector<Neighbors> add_neighbors(const FittedModel& fit,
                                     const data::Table& table,
                                     Prediction& result);

/// Replaces the errors of these rows, and their limits by the prediction plus and minus t errors. A
/// change of the coefficients changes the residuals of the neighbors, too: the error is that along
/// x - sum w X, with the slopes x of the row and X of its neighbors.
/// \param result  with errors and degrees of freedom that do not know of neighbors
/// Source: Cressie 1993, section 3.4 (universal kriging).
void replace_errors(const FittedModel& fit,
                    const data::Table& table,
                    const CoefficientSets& sets,
                    const PredictionOptions& options,
                    const std::vector<Neighbors>& neighbors,
                    Prediction& result);

}  // namespace silvafit::fit
