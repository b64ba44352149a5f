// SPDX-License-Identifier: MIT
#include "silvafit/fit/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <unordered_map>

#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Index kNewGroup = -1;

VectorXd to_vector(const std::vector<double>& values) {
  return Eigen::Map<const VectorXd>(values.data(), static_cast<Index>(values.size()));
}

[[noreturn]] void refuse_group(const data::Table& table,
                               std::size_t row,
                               const std::string& column,
                               std::string_view label) {
  Place place{.file = table.file(), .column = column};
  if (table.line(row) > 0) place.line = table.line(row);
  throw InputError(
      label.empty() ? "the group is missing" : fmt::format("'{}' is no group of the fit", label),
      place);
}

/// (N) the group of each row by its number in the fit, kNewGroup where the fit has none.
std::vector<Index> groups_of(const FittedModel& fit,
                             const data::Table& table,
                             NewGroups new_groups) {
  std::unordered_map<std::string_view, Index> number_of;
  for (std::size_t g = 0; g < fit.group_labels.size(); ++g) {
    number_of.emplace(fit.group_labels[g], static_cast<Index>(g));
  }
  const std::string& column = fit.specification.random->group;
  const data::TextColumn labels = table.labels(column);
  std::vector<Index> groups(table.rows(), kNewGroup);
  for (std::size_t row = 0; row < groups.size(); ++row) {
    const auto found = labels.is_missing(row) ? number_of.end() : number_of.find(labels[row]);
    if (found != number_of.end()) {
      groups[row] = found->second;
    } else if (new_groups == NewGroups::kError) {
      refuse_group(table, row, column, labels[row]);
    }
  }
  return groups;
}

/// (p x G + 1) the coefficients of each group, those of the population in the last column.
MatrixXd coefficients_by_group(const FittedModel& fit) {
  const auto group_count = static_cast<Index>(fit.group_labels.size());
  MatrixXd coefficients = fit.estimate.replicate(1, group_count + 1);
  for (std::size_t k = 0; k < fit.random_names.size(); ++k) {
    const auto found = std::ranges::find(fit.coefficient_names, fit.random_names[k]);
    const auto j = static_cast<Index>(found - fit.coefficient_names.begin());
    coefficients.row(j).head(group_count) += fit.random_effects.row(static_cast<Index>(k));
  }
  return coefficients;
}

/// (N x K) the parameters of the formula in each row.
MatrixXd parameter_values(const FittedModel& fit,
                          const data::Table& table,
                          const std::vector<Index>& groups) {
  const MatrixXd coefficients = coefficients_by_group(fit);
  const Index population = coefficients.cols() - 1;
  std::vector<Index> columns(table.rows(), population);
  for (std::size_t row = 0; row < groups.size(); ++row) {
    if (groups[row] != kNewGroup) columns[row] = groups[row];
  }
  const std::vector<ParameterModel>& parameters = fit.specification.parameters;
  MatrixXd values =
      MatrixXd::Zero(static_cast<Index>(table.rows()), static_cast<Index>(parameters.size()));
  Index j = 0;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    auto target = values.col(static_cast<Index>(k));
    if (parameters[k].has_intercept) target += coefficients.row(j++)(columns).transpose();
    for (const Covariate& covariate : parameters[k].covariates) {
      const VectorXd multiplier = to_vector(data::evaluate(covariate.value, table));
      target += coefficients.row(j++)(columns).transpose().cwiseProduct(multiplier);
    }
  }
  return values;
}

VectorXd mean_of(const FittedModel& fit, const data::Table& table, const MatrixXd& parameters) {
  const ModelSpecification& specification = fit.specification;
  std::vector<data::Program::Input> inputs;
  std::vector<const double*> values;
  for (std::size_t k = 0; k < specification.parameters.size(); ++k) {
    inputs.push_back({.name = specification.parameters[k].name});
    values.push_back(parameters.col(static_cast<Index>(k)).data());
  }
  std::vector<std::vector<double>> columns;
  for (const std::string& name : specification.predictors()) {
    columns.push_back(data::variable_values(name, table));
    inputs.push_back({.name = name});
  }
  for (const std::vector<double>& column : columns) values.push_back(column.data());

  VectorXd mean(static_cast<Index>(table.rows()));
  double* const outputs[] = {mean.data()};
  const data::Program program({&specification.formula.right, 1}, inputs);
  data::Program::Workspace workspace;
  program.evaluate(values, table.rows(), outputs, workspace);
  // A formula may hide a missing value, as min() and ifelse() do; a prediction may not.
  for (const std::vector<double>& column : columns) {
    mean = to_vector(column).array().isNaN().select(kNaN, mean);
  }
  return mean;
}

}  // namespace

Prediction predict(const FittedModel& fit,
                   const data::Table& table,
                   Level level,
                   const PredictionOptions& options) {
  const bool by_group = level == Level::kConditional && fit.has_random_effects();
  std::vector<Index> groups;
  if (by_group) groups = groups_of(fit, table, options.new_groups);
  Prediction result{.value = mean_of(fit, table, parameter_values(fit, table, groups)),
                    .is_new_group = std::vector<bool>(table.rows(), false)};
  for (std::size_t row = 0; row < groups.size(); ++row) {
    if (groups[row] != kNewGroup) continue;
    result.is_new_group[row] = true;
    if (options.new_groups == NewGroups::kMissing) result.value[static_cast<Index>(row)] = kNaN;
  }
  result.residual_sd = fit.residual_sd(result.value, table);
  return result;
}

}  // namespace silvafit::fit
