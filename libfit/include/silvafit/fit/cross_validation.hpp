// SPDX-License-Identifier: MIT
// Cross-validation: predictions of groups that were not in the fit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fit_statistics.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

struct CrossValidationOptions {
  /// Number of folds of the groups, at most the number of groups; 0 leaves out one group at a time.
  std::size_t folds = 10;
  /// The column of the groups; empty: that of the random effects, the coarser of two groupings.
  std::string group{};
  /// Number of trees per left-out group that are used as measured, drawn at random: they give the
  /// random effects with which the other trees of the group are predicted. 0: none.
  std::size_t measured = 0;
  std::uint64_t seed = 1;  ///< of the folds and of the measured trees
  unsigned threads = 0;    ///< over folds; 0: all cores
  /// Held coefficients, bounds and iterations of the fit, and the stop token. Method, restricted
  /// likelihood and points of quadrature are always those of the fit.
  FitModelOptions refit{};
  /// Called after each fold, if given, possibly from several threads.
  std::function<void(std::size_t done, std::size_t total)> progress{};
};

/// A fold without predictions.
struct FailedFold {
  std::vector<std::string> groups{};  ///< the groups without predictions
  std::string verdict{};
};

/// Predictions of each observation by a fit without its group. N observations of the full fit.
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
  FitStatistics statistics{};       ///< of those; NaN if there are none
  /// Mean of log p(y) of those, each alone: normal with mean f(beta) and variance Z Psi Z' +
  /// sigma^2 g^2, Z the slopes at b = 0.
  double log_density = 0.0;
  /// Observations with a density: without those in a stratum of the variance function that the
  /// other folds lack.
  std::size_t density_count = 0;
  std::size_t measured = 0;               ///< trees of each group used as measured
  Eigen::VectorXd calibrated{};           ///< (N) f(beta + b); NaN for the measured ones themselves
  std::size_t calibrated_count = 0;       ///< observations with a calibrated prediction
  FitStatistics calibrated_statistics{};  ///< of those; NaN if there are none
  /// Of f(beta) for the same observations, for comparison.
  FitStatistics uncalibrated_statistics{};
};

/// Refits a model without each fold of its groups, starting from the fit of all, and predicts the
/// fold. The folds depend only on the seed and the order of the groups' first appearance.
/// \param table  the data of the fit
/// \throws UsageError if the fit has not converged, there is no column of groups, it has fewer than
///   two groups, or measured trees are requested without random effects; InputError if a
///   row has no group; as fit_model for the table
CrossValidation cross_validate(const FittedModel& fit,
                               const data::Table& table,
                               const CrossValidationOptions& options = {});

}  // namespace silvafit::fit
