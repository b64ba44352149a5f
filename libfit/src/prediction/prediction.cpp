// SPDX-License-Identifier: MIT
#include "silvafit/fit/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "prediction/coefficient_sets.hpp"
#include "prediction/known_levels.hpp"
#include "prediction/marginal_mean.hpp"
#include "prediction/neighbor_residuals.hpp"
#include "prediction/prediction_intervals.hpp"
#include "prediction/residual_spread.hpp"
#include "prediction/row_mean.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

void check(const PredictionOptions& options) {
  if (options.interval && !(*options.interval > 0.0 && *options.interval < 1.0)) {
    throw UsageError(
        fmt::format("the level of an interval must be between 0 and 1, not {}", *options.interval));
  }
}

/// Replaces values by marginal means, for the rows whose sets require them.
class MarginalRows {
 public:
  MarginalRows(const FittedModel& fit,
               const data::Table& table,
               const CoefficientSets& sets,
               const PredictionOptions& options,
               bool with_gradient)
      : fit_(fit), table_(table), sets_(sets), options_(options), with_gradient_(with_gradient) {}

  void replace(Prediction& result) {
    for (std::size_t known = 0; known < fit_.random.size(); ++known) replace(known, result);
  }
  /// (N x p) derivatives by the coefficients; empty if no row is marginal.
  const MatrixXd& gradients() const { return gradients_; }

 private:
  void replace(std::size_t known, Prediction& result) {
    std::vector<std::size_t> rows;
    std::vector<Index> set_of_row;
    for (std::size_t row = 0; row < table_.rows(); ++row) {
      const Index set = sets_.set_of_row[row];
      const auto at = static_cast<std::size_t>(set);
      if (!sets_.is_marginal[at] || sets_.known[at] != known) continue;
      rows.push_back(row);
      set_of_row.push_back(set);
    }
    if (rows.empty()) return;
    const RowMean mean(fit_.specification, table_.select(rows));
    const MarginalMean found = marginal_mean(mean,
                                             mean.arguments(sets_.coefficients, set_of_row),
                                             open_covariance(fit_, known),
                                             options_.marginal_accuracy,
                                             with_gradient_);
    result.marginal_difference = std::max(result.marginal_difference, found.difference);
    if (with_gradient_ && gradients_.size() == 0) {
      gradients_.setZero(static_cast<Index>(table_.rows()), fit_.estimate.size());
    }
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto row = static_cast<Index>(rows[k]);
      result.value[row] = found.value[static_cast<Index>(k)];
      if (with_gradient_) gradients_.row(row) = found.gradient.row(static_cast<Index>(k));
    }
  }

  const FittedModel& fit_;
  const data::Table& table_;
  const CoefficientSets& sets_;
  const PredictionOptions& options_;
  bool with_gradient_;
  MatrixXd gradients_;
};

}  // namespace

Prediction predict(const FittedModel& fit,
                   const data::Table& table,
                   Level level,
                   const PredictionOptions& options) {
  check(options);
  if (const auto known = without_unknown_levels(fit, table)) {
    return predict(fit, *known, level, options);
  }
  const bool with_errors = options.interval.has_value() || options.standard_errors;
  CoefficientSets sets = coefficient_sets(fit, table, level, options, with_errors);
  const RowMean mean(fit.specification, table);
  Prediction result{.value = mean.mean(mean.arguments(sets.coefficients, sets.set_of_row)),
                    .is_new_group = sets.is_new_group,
                    .calibrated_from = sets.calibrated_from};
  MarginalRows marginal(fit, table, sets, options, with_errors);
  marginal.replace(result);
  result.residual_sd = residual_sd_if_known(fit, result.value, table);
  result.residual_gap = residual_sd_gaps(fit, table);
  if (fit.variance.correlation && level == Level::kCalibrated) {
    if (with_errors) {
      throw UsageError(
          "predictions from measured neighbors with correlated residuals have no "
          "standard errors and intervals; choose another `level`, or omit these");
    }
    add_neighbors(fit, table, result);
  }
  if (with_errors) add_errors(fit, table, sets, options, marginal.gradients(), result);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!sets.is_missing[row]) continue;
    const auto at = static_cast<Index>(row);
    result.value[at] = result.residual_sd[at] = kNaN;
    for (VectorXd* values : {&result.mean_error,
                             &result.prediction_error,
                             &result.degrees_of_freedom,
                             &result.lower,
                             &result.upper}) {
      if (values->size() > 0) (*values)[at] = kNaN;
    }
  }
  return result;
}

}  // namespace silvafit::fit
