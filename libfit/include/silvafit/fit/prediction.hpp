// SPDX-License-Identifier: MIT
// Predictions of a fitted model for new data.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/enum_words.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The random effects of a prediction. docs/prediction.md has the formulas.
enum class Level {
  kPopulation,   ///< f(beta): b = 0
  kConditional,  ///< f(beta + b): b of the group in the fit
  kCalibrated,   ///< f(beta + b): b from the measured trees of the table; see calibrate
  kMarginal,     ///< the mean of f(beta + b) over all groups, b ~ N(0, Psi)
};
constexpr std::array<std::string_view, 4> words_of(Level /*level*/) {
  return {"population", "conditional", "calibrated", "marginal"};
}

/// The conditional prediction for a group that is not in the fit, and the calibrated one for such a
/// group without a measured tree.
enum class NewGroups {
  kPopulation,  ///< that of the population, or of the coarser group if that is known
  kMarginal,    ///< the mean over all groups, or over those of the coarser group if that is known
  kMissing,     ///< NaN
  kError,       ///< none: InputError at the first such row
};
constexpr std::array<std::string_view, 4> words_of(NewGroups /*groups*/) {
  return {"population", "marginal", "missing", "error"};
}

/// The quantity of an interval.
enum class IntervalKind {
  kPrediction,  ///< a new tree's value
  kConfidence,  ///< the mean of such trees at the level
};
constexpr std::array<std::string_view, 2> words_of(IntervalKind /*kind*/) {
  return {"prediction", "confidence"};
}

/// A column that is itself a prediction: heights that a crown-base model needs.
struct UncertainColumn {
  std::string name{};
  Eigen::VectorXd mean_variance{};  ///< (N) of the column's mean; 0 where it was measured
  Eigen::VectorXd tree_variance{};  ///< (N) of the tree's own value around its prediction
};

struct PredictionOptions {
  NewGroups new_groups = NewGroups::kPopulation;
  SeenGroups seen_groups = SeenGroups::kFitted;  ///< of calibrated predictions
  /// Coverage of intervals, in (0, 1); none without.
  std::optional<double> interval{};
  IntervalKind interval_kind = IntervalKind::kPrediction;
  bool standard_errors = false;  ///< compute standard errors also without intervals
  std::vector<UncertainColumn> uncertain{};
  /// Of marginal means: tolerance for the relative difference of two quadratures of increasing
  /// size.
  double marginal_accuracy = 1e-8;
  unsigned threads = 1;
};

/// Predictions for N rows of a table, in its order.
struct Prediction {
  Eigen::VectorXd value{};        ///< (N) NaN if a column that the mean needs is missing
  Eigen::VectorXd residual_sd{};  ///< (N) of an observation around its prediction
  /// (N) the reason why a row has no value, if it is not that the mean has none there: "random
  /// effects not found"; else empty.
  std::vector<std::string> value_gap{};
  /// (N) the reason why a row has no residual_sd and no prediction interval: "missing noise",
  /// "unknown species"; else empty.
  std::vector<std::string> residual_gap{};
  /// (N) bits of the terms whose group is missing, or is not in the fit and has no measured tree;
  /// of nested terms only the last. Zero at the population and marginal levels and without random
  /// effects.
  std::vector<unsigned> unknown_terms{};
  /// (N) number of measured trees of the row's group for the calibration, -1 if it has the fit's
  /// own random effects; empty except for calibrated predictions.
  std::vector<Eigen::Index> calibrated_from{};
  // With intervals or standard errors:
  Eigen::VectorXd mean_error{};          ///< (N) standard error of the mean
  Eigen::VectorXd prediction_error{};    ///< (N) standard deviation of a new tree's value around it
  Eigen::VectorXd degrees_of_freedom{};  ///< (N) of the t distribution of intervals
  // With intervals:
  Eigen::VectorXd lower{};  ///< (N)
  Eigen::VectorXd upper{};  ///< (N)
  /// Largest relative difference of the last two quadratures of marginal means.
  double marginal_difference = 0.0;
};

/// Predicts the response of each row. Without random effects all levels are the same.
///
/// Standard errors are first-order ones. Limits of prediction intervals are quantiles of the
/// distribution of a new tree, a mixture of normal distributions over the errors of the
/// coefficients, by quadrature, widened for the degrees of freedom, and asymmetric if the mean
/// function is nonlinear. Those of confidence intervals are t standard errors away; of a mean that
/// is a function of one linear combination of coefficients, its values at the limits of that
/// combination. Coefficients without a standard error (fixed ones) are treated as known.
///
/// With correlated residuals a calibrated prediction of a row without a response is that of its own
/// value: the mean, and the residual that is expected from those of the measured rows of its group.
///
/// A column that only the variance function reads may be missing: residual_sd and prediction
/// intervals are then NaN. Only calibration needs it, for the weights of the measured trees.
/// \throws UsageError if a column that the mean, the group or calibration needs is missing, if the
///   interval is not in (0, 1), if standard errors are requested for calibrated predictions with
///   correlated residuals, or if an older file lacks data for intervals at the conditional
///   level; InputError for new groups with NewGroups::kError
Prediction predict(const FittedModel& fit,
                   const data::Table& table,
                   Level level,
                   const PredictionOptions& options = {});

}  // namespace silvafit::fit
