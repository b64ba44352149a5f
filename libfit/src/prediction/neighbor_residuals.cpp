// SPDX-License-Identifier: MIT
#include "prediction/neighbor_residuals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "correlation/correlation_structure.hpp"
#include "model/correlated_rows.hpp"
#include "model/group_labels.hpp"
#include "prediction/row_mean.hpp"
#include "prediction/student_quantiles.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

/// Rows of one group.
struct GroupRows {
  std::vector<Index> measured{};
  std::vector<Index> others{};
};

class NeighborResiduals {
 public:
  NeighborResiduals(const FittedModel& fit, const data::Table& table, Prediction& result)
      : fit_(fit),
        table_(table),
        correlation_(*fit.specification.correlation),
        result_(result),
        places_(MatrixXd::Zero(result.value.size(),
                               std::max<Index>(1, std::ssize(correlation_.columns)))),
        structure_(*fit.variance.correlation) {
    for (Index k = 0; k < std::ssize(correlation_.columns); ++k) {
      const std::vector<double> values =
          data::variable_values(correlation_.columns[static_cast<std::size_t>(k)], table);
      places_.col(k) = Eigen::Map<const VectorXd>(values.data(), std::ssize(values));
    }
    const auto numbers = table.numbers(fit.specification.formula.left);
    response_ = Eigen::Map<const VectorXd>(numbers.data(), std::ssize(numbers));
    const VectorXd extent = places_.array().isNaN().select(0.0, places_).colwise().maxCoeff() -
                            places_.array().isNaN().select(0.0, places_).colwise().minCoeff();
    structure_ = CorrelationStructure(*fit.variance.correlation, extent.norm());
    parameters_ = structure_.unconstrained(fit.variance.correlation->values);
    pairs_ = structure_.at(parameters_);
  }

  std::vector<Neighbors> add() {
    for (auto& [label, rows] : groups()) {
      if (rows.measured.empty() || rows.others.empty()) continue;
      add(label, rows);
      if (!fit_.has_random_effects()) count(rows);
    }
    return std::move(added_);
  }

 private:
  std::map<std::string, GroupRows> groups() const {
    std::map<std::string, GroupRows> result;
    const GroupLabels labels(fit_.specification, table_);
    data::TextColumn own;
    if (!correlation_.group.empty()) own = table_.labels(correlation_.group);
    for (Index row = 0; row < places_.rows(); ++row) {
      const auto at = static_cast<std::size_t>(row);
      const bool is_known = std::isfinite(result_.value[row]) && result_.residual_sd[row] > 0.0;
      if (!is_known || !places_.row(row).allFinite()) continue;
      std::string label;
      if (fit_.has_random_effects()) label = labels.of(fit_.random.size() - 1, at);
      if (fit_.has_random_effects() && label.empty()) continue;
      if (!correlation_.group.empty()) {
        if (own.is_missing(at)) continue;
        label += (label.empty() ? "" : "/") + std::string(own[at]);
      }
      GroupRows& group = result[label];
      (std::isfinite(response_[row]) ? group.measured : group.others).push_back(row);
    }
    return result;
  }

  void count(const GroupRows& rows) {
    result_.calibrated_from.resize(table_.rows());
    for (const Index row : rows.others) {
      result_.calibrated_from[static_cast<std::size_t>(row)] = std::ssize(rows.measured);
    }
  }

  void add(const std::string& label, GroupRows& rows) {
    const std::string gap = group_gap(*fit_.variance.correlation, std::ssize(rows.measured) + 1);
    if (!gap.empty()) {
      for (const Index row : rows.others) {
        result_.value[row] = result_.residual_sd[row] = kNaN;
        result_.value_gap[static_cast<std::size_t>(row)] = gap;
      }
      return;
    }
    for (const std::vector<Index>* const part : {&rows.measured, &rows.others}) {
      for (const Index row : *part) {
        require_known_time(
            structure_, places_(row, 0), data::place_of(table_, static_cast<std::size_t>(row), ""));
        places_(row, 0) = structure_.place(places_(row, 0));
      }
    }
    if (places_.cols() == 1) {
      std::ranges::stable_sort(rows.measured, {}, [this](Index i) { return places_(i, 0); });
    }
    const auto factor = structure_.factor(places_(rows.measured, Eigen::all), *pairs_);
    if (factor == nullptr) {
      throw InputError(
          fmt::format("a value is repeated, or nearly so, in the measured rows of group {}; "
                      "`correlation` needs another value in each",
                      label.empty() ? "of all rows" : label),
          data::place_of(table_,
                         static_cast<std::size_t>(rows.measured.front()),
                         fmt::format("{}", fmt::join(correlation_.columns, ", "))));
    }
    const VectorXd deviations = result_.residual_sd(rows.measured);
    const VectorXd known =
        (response_(rows.measured) - result_.value(rows.measured)).cwiseQuotient(deviations);
    MatrixXd inverse = MatrixXd::Identity(known.size(), known.size());
    factor->whiten(inverse);
    for (const Index row : rows.others) {
      VectorXd correlations(known.size());
      for (Index k = 0; k < known.size(); ++k) {
        const Index other = rows.measured[static_cast<std::size_t>(k)];
        const double distance = (places_.row(row) - places_.row(other)).norm();
        correlations[k] = pairs_->between(distance, places_(row, 0), places_(other, 0), nullptr);
      }
      const VectorXd whitened = inverse * correlations;
      const VectorXd weights = result_.residual_sd[row] * (inverse.transpose() * whitened);
      result_.value[row] += weights.dot(known);
      result_.residual_sd[row] *= std::sqrt(std::max(0.0, 1.0 - whitened.squaredNorm()));
      added_.push_back(
          {.row = row, .measured = rows.measured, .weights = weights.cwiseQuotient(deviations)});
    }
  }

  const FittedModel& fit_;
  const data::Table& table_;
  const Correlation& correlation_;
  Prediction& result_;
  MatrixXd places_;  ///< (N x d)
  VectorXd response_;
  CorrelationStructure structure_;
  VectorXd parameters_;
  std::unique_ptr<PairCorrelation> pairs_;
  std::vector<Neighbors> added_;
};

}  // namespace

std::string group_gap(const CorrelationEstimate& estimate, Index rows) {
  if (estimate.correlation.kind != Correlation::Kind::kCompoundSymmetry) return {};
  const double rho = estimate.values[0];
  if (!(1.0 + static_cast<double>(rows - 1) * rho < 0.0)) return {};
  return fmt::format("a group of {} rows cannot have the correlation rho = {:.3g}", rows, rho);
}

std::vector<Neighbors> add_neighbors(const FittedModel& fit,
                                     const data::Table& table,
                                     Prediction& result) {
  const Correlation& correlation = *fit.specification.correlation;
  const bool is_order =
      correlation.columns.empty() && correlation.kind != Correlation::Kind::kCompoundSymmetry;
  const std::string& response = fit.specification.formula.left;
  if (is_order || !table.has(response) || !table.is_numeric(response)) return {};
  return NeighborResiduals(fit, table, result).add();
}

void replace_errors(const FittedModel& fit,
                    const data::Table& table,
                    const CoefficientSets& sets,
                    const PredictionOptions& options,
                    const std::vector<Neighbors>& neighbors,
                    Prediction& result) {
  if (neighbors.empty()) return;
  const RowMean mean(fit.specification, table);
  const MatrixXd gradient = mean.gradient(mean.arguments(sets.coefficients, sets.set_of_row));
  const ParameterDesign& design = mean.design();
  const Index p = design.coefficient_count();
  MatrixXd slopes(gradient.rows(), p);
  for (Index k = 0; k < p; ++k) {
    for (Index row = 0; row < slopes.rows(); ++row) {
      slopes(row, k) = gradient(row, design.parameter_of(k)) * design.multiplier(k, row);
    }
  }
  std::optional<StudentQuantiles> quantiles;
  if (options.interval) quantiles.emplace(0.5 + 0.5 * *options.interval);
  for (const Neighbors& of : neighbors) {
    const Index row = of.row;
    const VectorXd slope =
        slopes.row(row).transpose() - slopes(of.measured, Eigen::all).transpose() * of.weights;
    const Index set = sets.set_of_row[static_cast<std::size_t>(row)];
    const Eigen::Map<const MatrixXd> covariance(sets.covariances.col(set).data(), p, p);
    const double variance = slope.dot(covariance * slope);
    const double residual = result.residual_sd[row];
    result.mean_error[row] = std::sqrt(variance);
    result.prediction_error[row] = std::sqrt(variance + residual * residual);
    if (!quantiles) continue;
    const double error = options.interval_kind == IntervalKind::kConfidence
                             ? result.mean_error[row]
                             : result.prediction_error[row];
    const double margin = quantiles->at(result.degrees_of_freedom[row]) * error;
    result.lower[row] = result.value[row] - margin;
    result.upper[row] = result.value[row] + margin;
  }
}

}  // namespace silvafit::fit
