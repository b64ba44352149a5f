// SPDX-License-Identifier: MIT
// Fits whose figures a test sets itself.
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

/// A fit by Laplace's method without an error of its coefficients, sigma 1; the rest is the test's.
inline FittedModel model(const std::string& formula,
                         const std::vector<std::string>& coefficients,
                         const std::string& random) {
  FittedModel fit{.specification = {.formula = data::parse_formula(formula)}};
  for (const std::string& name : coefficients) {
    fit.specification.parameters.push_back(parse_parameter_model(name + " ~ 1"));
  }
  fit.coefficient_names = coefficients;
  const auto p = static_cast<Eigen::Index>(coefficients.size());
  fit.covariance.setZero(p, p);
  fit.method = Method::kLaplace;
  const std::vector<RandomEffects> effects = parse_random_effects(random);
  fit.specification.random = effects.back();
  fit.random_names = effects.back().coefficients;
  fit.random_effects.resize(static_cast<Eigen::Index>(fit.random_names.size()), 0);
  if (effects.size() > 1) {
    fit.specification.outer_random = effects.front();
    fit.outer.names = effects.front().coefficients;
    fit.outer.effects.resize(static_cast<Eigen::Index>(fit.outer.names.size()), 0);
  }
  fit.degrees_of_freedom = Eigen::VectorXd::Constant(1, 100.0);
  fit.sigma = 1.0;
  return fit;
}

}  // namespace silvafit::fit
