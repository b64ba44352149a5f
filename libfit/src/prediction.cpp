// SPDX-License-Identifier: MIT
#include "silvafit/fit/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>
#include <unordered_map>

#include "group_labels.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/program.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

/// Groups by their labels.
std::unordered_map<std::string, Index> numbered(const std::vector<std::string>& labels) {
  std::unordered_map<std::string, Index> number_of;
  for (std::size_t g = 0; g < labels.size(); ++g) {
    number_of.emplace(labels[g], static_cast<Index>(g));
  }
  return number_of;
}

/// Which column of coefficients_by_group() each row has.
struct RowGroups {
  std::vector<Index> column{};  ///< (N)
  std::vector<bool> is_new{};   ///< (N) true where the fit does not know the row's (finer) group
};

RowGroups groups_of(const FittedModel& fit, const data::Table& table, NewGroups new_groups) {
  const auto inner_of = numbered(fit.group_labels);
  const auto outer_of = numbered(fit.outer.labels);
  const auto inner_count = static_cast<Index>(fit.group_labels.size());
  const Index population = inner_count + static_cast<Index>(fit.outer.labels.size());
  const GroupLabels labels(fit.specification, table);
  RowGroups groups{.column = std::vector<Index>(table.rows(), population),
                   .is_new = std::vector<bool>(table.rows(), false)};
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::string label = labels.inner(row);
    if (const auto found = inner_of.find(label); !label.empty() && found != inner_of.end()) {
      groups.column[row] = found->second;
      continue;
    }
    if (new_groups == NewGroups::kError) {
      refuse_group(table, row, fit.specification.random->group, label);
    }
    groups.is_new[row] = true;
    const auto outer = outer_of.find(labels.outer(row));
    if (outer != outer_of.end()) groups.column[row] = inner_count + outer->second;
  }
  return groups;
}

void add_effects(const FittedModel& fit,
                 const std::vector<std::string>& names,
                 const Eigen::VectorXd& effects,
                 Eigen::Ref<VectorXd> coefficients) {
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto found = std::ranges::find(fit.coefficient_names, names[k]);
    coefficients[found - fit.coefficient_names.begin()] += effects[static_cast<Index>(k)];
  }
}

/// (p x G + S + 1) the coefficients of each group, of each group of the coarser grouping when the
/// finer one is not known, and those of the population.
MatrixXd coefficients_by_group(const FittedModel& fit) {
  const auto inner_count = static_cast<Index>(fit.group_labels.size());
  const auto outer_count = static_cast<Index>(fit.outer.labels.size());
  MatrixXd coefficients = fit.estimate.replicate(1, inner_count + outer_count + 1);
  for (Index s = 0; s < outer_count; ++s) {
    const std::string prefix = fit.outer.labels[static_cast<std::size_t>(s)] + "/";
    add_effects(fit, fit.outer.names, fit.outer.effects.col(s), coefficients.col(inner_count + s));
    for (Index g = 0; g < inner_count; ++g) {
      if (!fit.group_labels[static_cast<std::size_t>(g)].starts_with(prefix)) continue;
      add_effects(fit, fit.outer.names, fit.outer.effects.col(s), coefficients.col(g));
    }
  }
  for (Index g = 0; g < inner_count; ++g) {
    add_effects(fit, fit.random_names, fit.random_effects.col(g), coefficients.col(g));
  }
  return coefficients;
}

/// (N x K) the parameters of the formula in each row.
MatrixXd parameter_values(const FittedModel& fit,
                          const data::Table& table,
                          const RowGroups& groups) {
  const MatrixXd coefficients = coefficients_by_group(fit);
  const std::vector<Index> columns = groups.column.empty()
                                         ? std::vector<Index>(table.rows(), coefficients.cols() - 1)
                                         : groups.column;
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
  RowGroups groups;
  if (by_group) groups = groups_of(fit, table, options.new_groups);
  Prediction result{.value = mean_of(fit, table, parameter_values(fit, table, groups)),
                    .is_new_group = std::vector<bool>(table.rows(), false)};
  for (std::size_t row = 0; row < groups.is_new.size(); ++row) {
    if (!groups.is_new[row]) continue;
    result.is_new_group[row] = true;
    if (options.new_groups == NewGroups::kMissing) result.value[static_cast<Index>(row)] = kNaN;
  }
  result.residual_sd = fit.residual_sd(result.value, table);
  return result;
}

}  // namespace silvafit::fit
