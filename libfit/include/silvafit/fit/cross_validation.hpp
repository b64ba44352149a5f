// SPDX-License-Identifier: MIT
// How well a model predicts groups that it was not fitted to.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fit_statistics.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

struct CrossValidationOptions {
  /// Parts that the groups are dealt to; 0 leaves out one group at a time, and there are never more
  /// parts than groups.
  std::size_t folds = 10;
  /// The column of the groups; empty: that of the random effects, the coarser of two groupings.
  std::string group{};
  /// Trees of each group that count as measured when it is left out, drawn at random: the random
  /// effects of the group are predicted from them, and its other trees with these. 0: none.
  std::size_t measured = 0;
  std::uint64_t seed = 1;  ///< of the dealing and the drawing
  unsigned threads = 0;    ///< over folds; 0: as many as there are cores
  /// Held coefficients, bounds and iterations, as the fit had them, and the stop token. Method,
  /// restricted likelihood and points of quadrature are those of the fit whatever is here.
  FitModelOptions refit{};
  /// Called as folds are done, if given; may come from several threads.
  std::function<void(std::size_t done, std::size_t total)> progress{};
};

/// A fold without predictions.
struct FailedFold {
  std::vector<std::string> groups{};  ///< that it would have predicted
  std::string verdict{};
};

/// Predictions of each observation by a fit that has seen nothing of its group. N observations of
/// the full fit.
struct CrossValidation {
  std::string group{};
  std::size_t groups = 0;
  std::size_t folds = 0;
  std::uint64_t seed = 0;
  std::vector<FailedFold> failed{};
  std::vector<std::size_t> rows{};  ///< (N) of the table
  std::vector<std::size_t> fold{};  ///< (N) of each observation, from 0
  Eigen::VectorXd observed{};       ///< (N)
  Eigen::VectorXd predicted{};      ///< (N) f(beta); NaN in a failed fold
  std::size_t predicted_count = 0;  ///< observations with a prediction
  FitStatistics statistics{};       ///< of those; NaN where there is none
  /// Mean of log p(y) of those, each alone: normal with mean f(beta) and variance Z Psi Z' +
  /// sigma^2 g^2, Z the slopes at b = 0.
  double log_density = 0.0;
  /// Observations with a density: not those in a stratum of the variance function that the data
  /// they were predicted from lack.
  std::size_t density_count = 0;
  std::size_t measured = 0;               ///< trees of each group that were measured
  Eigen::VectorXd calibrated{};           ///< (N) f(beta + b); NaN for the measured ones themselves
  std::size_t calibrated_count = 0;       ///< observations with a calibrated prediction
  FitStatistics calibrated_statistics{};  ///< of those; NaN where there is none
  /// Of f(beta) for the same observations, to compare with.
  FitStatistics uncalibrated_statistics{};
};

/// Refits a model without each fold of its groups, starting from the fit of all, and predicts the
/// fold. The dealing depends on the seed and the order of the groups' first appearance only.
/// \param table  the data of the fit
/// \throws UsageError if the fit has not converged, there is no column to tell groups by, or it has
///   fewer than two groups, or measured trees are asked for without random effects; InputError if a
///   row has no group; as fit_model for the table
CrossValidation cross_validate(const FittedModel& fit,
                               const data::Table& table,
                               const CrossValidationOptions& options = {});

}  // namespace silvafit::fit
