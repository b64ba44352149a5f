// SPDX-License-Identifier: MIT
#include "prediction/neighbor_residuals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "correlation/correlation_structure.hpp"
#include "model/group_labels.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

/// Rows of one group.
struct Neighbors {
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
    for (double& place : places_.reshaped()) place = structure_.place(place);
    const auto numbers = table.numbers(fit.specification.formula.left);
    response_ = Eigen::Map<const VectorXd>(numbers.data(), std::ssize(numbers));
    const VectorXd extent = places_.array().isNaN().select(0.0, places_).colwise().maxCoeff() -
                            places_.array().isNaN().select(0.0, places_).colwise().minCoeff();
    structure_ = CorrelationStructure(*fit.variance.correlation, extent.norm());
    parameters_ = structure_.unconstrained(fit.variance.correlation->values);
    pairs_ = structure_.at(parameters_);
  }

  void add() {
    for (auto& [label, rows] : groups()) {
      if (rows.measured.empty() || rows.others.empty()) continue;
      add(label, rows);
    }
  }

 private:
  std::map<std::string, Neighbors> groups() const {
    std::map<std::string, Neighbors> result;
    const GroupLabels labels(fit_.specification, table_);
    data::TextColumn own;
    if (!correlation_.group.empty()) own = table_.labels(correlation_.group);
    for (Index row = 0; row < places_.rows(); ++row) {
      const auto at = static_cast<std::size_t>(row);
      const bool is_known = std::isfinite(result_.value[row]) && result_.residual_sd[row] > 0.0;
      const bool is_time =
          structure_.correlation().kind != Correlation::Kind::kSymmetric || places_(row, 0) >= 0.0;
      if (!is_known || !is_time || !places_.row(row).allFinite()) continue;
      std::string label;
      if (fit_.has_random_effects()) label = labels.of(fit_.random.size() - 1, at);
      if (fit_.has_random_effects() && label.empty()) continue;
      if (!correlation_.group.empty()) {
        if (own.is_missing(at)) continue;
        label += (label.empty() ? "" : "/") + std::string(own[at]);
      }
      Neighbors& group = result[label];
      (std::isfinite(response_[row]) ? group.measured : group.others).push_back(row);
    }
    return result;
  }

  void add(const std::string& label, Neighbors& rows) {
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
    MatrixXd known =
        (response_(rows.measured) - result_.value(rows.measured)).cwiseQuotient(deviations);
    factor->whiten(known);
    for (const Index row : rows.others) {
      MatrixXd weights(known.rows(), 1);
      for (Index k = 0; k < weights.rows(); ++k) {
        const Index other = rows.measured[static_cast<std::size_t>(k)];
        const double distance = (places_.row(row) - places_.row(other)).norm();
        weights(k, 0) = pairs_->between(distance, places_(row, 0), places_(other, 0), nullptr);
      }
      factor->whiten(weights);
      result_.value[row] += result_.residual_sd[row] * weights.col(0).dot(known.col(0));
      result_.residual_sd[row] *= std::sqrt(std::max(0.0, 1.0 - weights.squaredNorm()));
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
};

}  // namespace

void add_neighbors(const FittedModel& fit, const data::Table& table, Prediction& result) {
  const Correlation& correlation = *fit.specification.correlation;
  const bool is_order =
      correlation.columns.empty() && correlation.kind != Correlation::Kind::kCompoundSymmetry;
  const std::string& response = fit.specification.formula.left;
  if (is_order || !table.has(response) || !table.is_numeric(response)) return;
  NeighborResiduals(fit, table, result).add();
}

}  // namespace silvafit::fit
