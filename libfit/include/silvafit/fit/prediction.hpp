// SPDX-License-Identifier: MIT
// What a fitted model says of new data.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Which random effects a prediction has.
enum class Level {
  kPopulation,   ///< f(beta): those of a group of which nothing is known, b = 0
  kConditional,  ///< f(beta + b): those estimated for the group
};

/// What a conditional prediction is for a group that the fit has not seen.
enum class NewGroups {
  kPopulation,  ///< that of the population, or of the coarser group if that was seen
  kMissing,     ///< NaN
  kError,       ///< none: InputError at the first such row
};

struct PredictionOptions {
  NewGroups new_groups = NewGroups::kPopulation;
};

/// Predictions for N rows of a table, in its order.
struct Prediction {
  Eigen::VectorXd value{};        ///< (N) NaN where a column that the mean needs is missing
  Eigen::VectorXd residual_sd{};  ///< (N) of an observation around its prediction
  /// (N) true where the row's group is missing or was not seen by the fit; all false at the
  /// population level and without random effects.
  std::vector<bool> is_new_group{};
};

/// Predicts the response of each row. Without random effects both levels are the same.
/// \throws UsageError if a column that the mean, the variance function or, at the conditional
///   level, the group needs is not there; InputError for new groups where the options say so
Prediction predict(const FittedModel& fit,
                   const data::Table& table,
                   Level level,
                   const PredictionOptions& options = {});

}  // namespace silvafit::fit
