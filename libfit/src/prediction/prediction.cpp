// SPDX-License-Identifier: MIT
#include "silvafit/fit/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "prediction/coefficient_sets.hpp"
#include "prediction/marginal_mean.hpp"
#include "prediction/neighbor_residuals.hpp"
#include "prediction/prediction_intervals.hpp"
#include "prediction/residual_spread.hpp"
#include "prediction/row_mean.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"

namespace silvafit::fit {
namespace {

void check(const PredictionOptions& options) {
  if (options.interval && !(*options.interval > 0.0 && *options.interval < 1.0)) {
    throw UsageError(
        fmt::format("the level of an interval must be between 0 and 1, not {}", *options.interval));
  }
}

/// Equal text, or the same number: "01" is 1.
bool is_known(const std::string& label, const std::vector<std::string>& known) {
  if (std::ranges::find(known, label) != known.end()) return true;
  double number = 0.0;
  if (!data::parse_number(label, number)) return false;
  return std::ranges::any_of(known, [number](const std::string& one) {
    double value = 0.0;
    return data::parse_number(one, value) && value == number;
  });
}

/// The labels of a column, unknown ones missing; none if all are known.
std::optional<data::TextColumn> known_labels(const ColumnLevels& levels, const data::Table& table) {
  const data::TextColumn labels = table.labels(levels.column);
  std::vector<bool> is_wanted;
  for (const std::string& label : labels.levels()) {
    is_wanted.push_back(is_known(label, levels.labels));
  }
  if (std::ranges::find(is_wanted, false) == is_wanted.end()) return std::nullopt;
  data::TextColumn result;
  result.reserve(labels.size());
  for (std::size_t row = 0; row < labels.size(); ++row) {
    if (labels.is_missing(row) || !is_wanted[labels.code(row)]) {
      result.append_missing();
    } else {
      result.append(labels[row]);
    }
  }
  return result;
}

/// Numbers remain numbers, because the formula may read them, too.
std::vector<double> where_known(std::vector<double> numbers, const data::TextColumn& labels) {
  for (std::size_t row = 0; row < numbers.size(); ++row) {
    if (labels.is_missing(row)) numbers[row] = data::kMissing;
  }
  return numbers;
}

/// The table with missing values for levels of factors that the fit does not have: they have no
/// coefficient, and the first level is not an estimate of them. None if there are no such levels.
std::optional<data::Table> without_unknown_levels(const FittedModel& fit,
                                                  const data::Table& table) {
  std::optional<data::Table> result;
  for (const ColumnLevels& levels : fit.levels) {
    const auto& factors = fit.specification.factors;
    if (std::ranges::find(factors, levels.column) == factors.end()) continue;
    std::optional<data::TextColumn> known = known_labels(levels, table);
    if (!known) continue;
    if (!result) result = table;
    if (table.is_numeric(levels.column)) {
      const auto numbers = table.numbers(levels.column);
      result->set(levels.column, where_known({numbers.begin(), numbers.end()}, *known));
    } else {
      result->set(levels.column, *std::move(known));
    }
  }
  return result;
}

/// Replaces values by marginal means, for the rows whose sets require them.
/// \returns (N x p) their derivatives by the coefficients; empty if no row is marginal
MatrixXd take_marginal(const FittedModel& fit,
                       const data::Table& table,
                       const CoefficientSets& sets,
                       const PredictionOptions& options,
                       bool with_gradient,
                       Prediction& result) {
  MatrixXd gradients;
  for (const std::vector<bool>& known :
       std::set<std::vector<bool>>(sets.known.begin(), sets.known.end())) {
    std::vector<std::size_t> rows;
    std::vector<Index> set_of_row;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const Index set = sets.set_of_row[row];
      const auto at = static_cast<std::size_t>(set);
      if (!sets.is_marginal[at] || sets.known[at] != known) continue;
      rows.push_back(row);
      set_of_row.push_back(set);
    }
    if (rows.empty()) continue;
    const RowMean mean(fit.specification, table.select(rows));
    const MarginalMean found = marginal_mean(mean,
                                             mean.arguments(sets.coefficients, set_of_row),
                                             open_covariance(fit, known),
                                             options.marginal_accuracy,
                                             with_gradient);
    result.marginal_difference = std::max(result.marginal_difference, found.difference);
    if (with_gradient && gradients.size() == 0) {
      gradients.setZero(static_cast<Index>(table.rows()), fit.estimate.size());
    }
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto row = static_cast<Index>(rows[k]);
      const bool has_center = std::isfinite(result.value[row]);
      result.value[row] = found.value[static_cast<Index>(k)];
      if (has_center && std::isnan(result.value[row])) {
        result.value_gap[rows[k]] =
            "the mean over groups does not exist, because the curve has a pole or is not defined "
            "among them";
      }
      if (with_gradient) gradients.row(row) = found.gradient.row(static_cast<Index>(k));
    }
  }
  return gradients;
}

/// Why the random effects of a group were not found.
std::string effects_gap(const FittedModel& fit, Index trees) {
  std::string why = fit.variance.correlation ? group_gap(*fit.variance.correlation, trees) : "";
  for (const Evidence& of : fit.convergence.evidence) {
    const bool is_exact = of.kind == Evidence::Kind::kBoundary && of.term.starts_with("sd of ");
    if (why.empty() && is_exact) why = fmt::format("the residual {} is 0", of.term);
  }
  return "random effects not found" + (why.empty() ? "" : ": " + why);
}

/// (N) the reasons of rows whose group has no random effects.
std::vector<std::string> value_gaps(const FittedModel& fit,
                                    const CoefficientSets& sets,
                                    Index rows) {
  std::vector<std::string> result(static_cast<std::size_t>(rows));
  for (std::size_t row = 0; row < sets.calibrated_from.size(); ++row) {
    if (sets.coefficients.col(sets.set_of_row[row]).allFinite()) continue;
    result[row] = effects_gap(fit, sets.calibrated_from[row]);
  }
  return result;
}

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
                    .unknown_terms = sets.unknown_terms,
                    .calibrated_from = sets.calibrated_from};
  result.value_gap = value_gaps(fit, sets, result.value.size());
  const MatrixXd gradients = take_marginal(fit, table, sets, options, with_errors, result);
  result.residual_sd = residual_sd_if_known(fit, result.value, table);
  result.residual_gap = residual_sd_gaps(fit, table);
  std::vector<Neighbors> neighbors;
  if (fit.variance.correlation && level == Level::kCalibrated) {
    neighbors = add_neighbors(fit, table, result);
    if (with_errors && !neighbors.empty() && !options.uncertain.empty()) {
      throw UsageError(
          "predictions from measured neighbors with correlated residuals have no standard errors "
          "and "
          "intervals where other columns are predicted, too; choose another `level`, or omit "
          "these");
    }
  }
  if (with_errors) {
    add_errors(fit, table, sets, options, gradients, result);
    replace_errors(fit, table, sets, options, neighbors, result);
  }
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!sets.is_missing[row] && result.value_gap[row].empty()) continue;
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
