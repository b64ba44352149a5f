// SPDX-License-Identifier: MIT
#include "model/held_coefficients.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;
using Values = std::map<std::string, double>;

/// Moves held coefficients of one parameter into the formula.
void hold_in(ParameterModel& parameter, const Values& held, Expression& formula) {
  Expression constant = Expression::constant(0.0);
  const auto take = [&](const std::string& name, const Expression& multiplier) {
    const auto found = held.find(name);
    if (found == held.end()) return false;
    constant = constant + found->second * multiplier;
    return true;
  };
  if (parameter.has_intercept && take(parameter.name, Expression::constant(1.0))) {
    parameter.has_intercept = false;
  }
  std::erase_if(parameter.covariates, [&](const Covariate& covariate) {
    return take(parameter.name + ":" + covariate.label, covariate.value);
  });
  const bool is_left = parameter.has_intercept || !parameter.covariates.empty();
  formula = formula.substitute(
      parameter.name, is_left ? Expression::variable(parameter.name) + constant : constant);
}

}  // namespace

void check_known(const ModelSpecification& specification, const std::string& name) {
  const std::vector<std::string> known = specification.coefficient_names();
  if (std::ranges::find(known, name) == known.end()) {
    throw UsageError(
        fmt::format("unknown coefficient '{}'; available: {}", name, fmt::join(known, ", ")));
  }
}

void check_holdable(const ModelSpecification& specification, const std::string& name) {
  check_known(specification, name);
  for (const RandomEffects& term : specification.random) {
    if (std::ranges::find(term.coefficients, name) == term.coefficients.end()) continue;
    throw UsageError(
        fmt::format("{} has a random effect by {}, so it cannot be fixed; remove the random "
                    "effect or the fixed value",
                    name,
                    term.group));
  }
}

ModelSpecification with_constants(const ModelSpecification& specification, const Values& held) {
  for (const auto& [name, value] : held) {
    check_holdable(specification, name);
    if (!std::isfinite(value))
      throw UsageError(fmt::format("the fixed value of {} is not a number", name));
  }
  ModelSpecification result = specification;
  for (ParameterModel& parameter : result.parameters) {
    hold_in(parameter, held, result.formula.right);
  }
  std::erase_if(result.parameters, [](const ParameterModel& parameter) {
    return !parameter.has_intercept && parameter.covariates.empty();
  });
  return result;
}

ModelSpecification with_held(const ModelSpecification& specification, const Values& held) {
  ModelSpecification result = with_constants(specification, held);
  if (result.parameters.empty()) {
    throw UsageError("all coefficients are fixed; at least one must be estimated");
  }
  return result;
}

}  // namespace silvafit::fit
