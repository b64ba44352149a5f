// SPDX-License-Identifier: MIT
// Fits with estimates set by a test.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

inline data::TextColumn texts(const std::vector<std::string>& labels) {
  data::TextColumn column;
  for (const std::string& label : labels) column.append(label);
  return column;
}

/// A fit by Laplace's method with coefficients without error and sigma 1; tests set the rest.
inline FittedModel model(const std::string& formula,
                         const std::vector<std::string>& coefficients,
                         const std::string& random) {
  FittedModel fit({.formula = data::parse_formula(formula)});
  for (const std::string& name : coefficients) {
    fit.specification.parameters.push_back(parse_parameter_model(name + " ~ 1"));
  }
  fit.coefficient_names = coefficients;
  const auto p = static_cast<Eigen::Index>(coefficients.size());
  fit.covariance.setZero(p, p);
  fit.method = Method::kLaplace;
  fit.specification.random = parse_random_effects(random);
  for (const RandomEffects& term : fit.specification.random) {
    const auto q = static_cast<Eigen::Index>(term.coefficients.size());
    fit.random.push_back({.names = term.coefficients, .effects = Eigen::MatrixXd(q, 0)});
  }
  fit.degrees_of_freedom = Eigen::VectorXd::Constant(1, 100.0);
  fit.sigma = 1.0;
  return fit;
}

}  // namespace silvafit::fit
