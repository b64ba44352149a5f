// SPDX-License-Identifier: MIT
#include "prediction/residual_spread.hpp"

#include <algorithm>
#include <cmath>

#include "silvafit/base/constants.hpp"
#include "silvafit/data/program.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

/// The column behind a variable of the variance function, which may be `column == "text"`.
std::string column_of(const std::string& variable) {
  data::TextMatch match;
  return data::is_text_match(variable, match) ? match.column : variable;
}

bool has_columns(const VarianceFactor& factor, const data::Table& table) {
  const auto has = [&](const std::string& name) { return name.empty() || table.has(name); };
  return has(column_of(factor.column)) && has(factor.stratum);
}

/// Adds the rows with missing values in a factor's column.
void add_values(const VarianceFactor& factor,
                const data::Table& table,
                std::vector<std::string>& gaps) {
  if (factor.column.empty()) return;
  const std::string column = column_of(factor.column);
  const bool is_there = table.has(column);
  const std::vector<double> values =
      is_there ? data::variable_values(factor.column, table) : std::vector<double>();
  for (std::size_t row = 0; row < gaps.size(); ++row) {
    if (!gaps[row].empty() || (is_there && !std::isnan(values[row]))) continue;
    gaps[row] = "missing " + column;
  }
}

/// Adds the rows with missing or unknown strata of a factor.
void add_strata(const VarianceFactorEstimate& estimate,
                const data::Table& table,
                std::vector<std::string>& gaps) {
  const std::string& column = estimate.factor.stratum;
  if (column.empty()) return;
  const bool is_there = table.has(column);
  const data::TextColumn labels = is_there ? table.labels(column) : data::TextColumn();
  for (std::size_t row = 0; row < gaps.size(); ++row) {
    if (!gaps[row].empty()) continue;
    if (!is_there || labels.is_missing(row)) {
      gaps[row] = "missing " + column;
    } else if (std::ranges::find(estimate.strata, labels[row]) == estimate.strata.end()) {
      gaps[row] = "unknown " + column;
    }
  }
}

}  // namespace

VectorXd residual_sd_if_known(const FittedModel& fit,
                              const Eigen::Ref<const VectorXd>& fitted,
                              const data::Table& table) {
  const bool is_known = std::ranges::all_of(
      fit.variance.factors,
      [&](const VarianceFactorEstimate& estimate) { return has_columns(estimate.factor, table); });
  if (is_known) return fit.residual_sd(fitted, table);
  return VectorXd::Constant(fitted.size(), kNaN);
}

bool residual_follows_mean(const FittedModel& fit) {
  return std::ranges::any_of(fit.variance.factors, [](const VarianceFactorEstimate& estimate) {
    return estimate.factor.column.empty() && kind_of(estimate.factor).reads_value();
  });
}

std::vector<std::string> residual_sd_gaps(const FittedModel& fit, const data::Table& table) {
  std::vector<std::string> gaps(table.rows());
  for (const VarianceFactorEstimate& estimate : fit.variance.factors) {
    add_values(estimate.factor, table, gaps);
    add_strata(estimate, table, gaps);
  }
  return gaps;
}

}  // namespace silvafit::fit
