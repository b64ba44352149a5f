// SPDX-License-Identifier: MIT
#include "silvafit/fit/parameter_design.hpp"

namespace silvafit::fit {

ParameterDesign::ParameterDesign(Index parameters, Index rows)
    : coefficients_of_(static_cast<std::size_t>(parameters)), covariates_(rows, 0) {
  for (Index k = 0; k < parameters; ++k) add(k, -1);
}

ParameterDesign::ParameterDesign(const std::vector<ParameterModel>& parameters,
                                 const data::Table& table,
                                 const std::vector<std::size_t>& rows)
    : coefficients_of_(parameters.size()) {
  std::vector<VectorXd> columns;
  const auto add_covariates = [&](std::size_t k, const std::vector<Covariate>& covariates) {
    for (const Covariate& covariate : covariates) {
      add(static_cast<Index>(k), std::ssize(columns));
      const std::vector<double> values = data::evaluate(covariate.value, table);
      VectorXd& column = columns.emplace_back(std::ssize(rows));
      for (std::size_t i = 0; i < rows.size(); ++i) column[static_cast<Index>(i)] = values[rows[i]];
    }
  };
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k].has_intercept) add(static_cast<Index>(k), -1);
    add_covariates(k, parameters[k].covariates);
  }
  for (std::size_t k = 0; k < parameters.size(); ++k) add_covariates(k, parameters[k].random_only);
  covariates_.resize(std::ssize(rows), std::ssize(columns));
  for (Index k = 0; k < covariates_.cols(); ++k) {
    covariates_.col(k) = columns[static_cast<std::size_t>(k)];
  }
}

void ParameterDesign::add(Index parameter, Index covariate) {
  coefficients_of_[static_cast<std::size_t>(parameter)].push_back(coefficient_count());
  parameter_of_.push_back(parameter);
  covariate_of_.push_back(covariate);
}

bool ParameterDesign::has_covariates(Index parameter) const {
  const std::vector<Index>& coefficients = coefficients_of(parameter);
  return !coefficients.empty() && multiplier(coefficients.back()) != nullptr;
}

void ParameterDesign::differentiate(
    Index coefficient, Index begin, Index rows, const double* by_parameter, double* target) const {
  Eigen::Map<Eigen::ArrayXd> result(target, rows);
  result = Eigen::Map<const Eigen::ArrayXd>(by_parameter, rows);
  const double* const multiplier = this->multiplier(coefficient);
  if (multiplier != nullptr) result *= Eigen::Map<const Eigen::ArrayXd>(multiplier + begin, rows);
}

ParameterDesign ParameterDesign::part(const std::vector<Index>& rows) const {
  ParameterDesign result = *this;
  result.covariates_ = covariates_(rows, Eigen::all);
  return result;
}

}  // namespace silvafit::fit
