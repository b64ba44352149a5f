// SPDX-License-Identifier: MIT
#include "model/held_coefficients.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;
using Values = std::map<std::string, double>;

/// Whether a parameter still has coefficients of either kind.
bool is_left(const ParameterModel& parameter) {
  return parameter.has_intercept || !parameter.covariates.empty() || !parameter.random_only.empty();
}

/// Moves held coefficients of one parameter into the formula; their random effects remain.
void hold_in(ParameterModel& parameter, const Values& held, ModelSpecification& model) {
  Expression constant = Expression::constant(0.0);
  const auto take = [&](const Covariate& covariate) {
    const std::string name = parameter.coefficient_name(covariate);
    const auto found = held.find(name);
    if (found == held.end()) return false;
    constant = constant + found->second * covariate.value;
    if (has_effects(model, name)) parameter.random_only.push_back(covariate);
    return true;
  };
  if (parameter.has_intercept && take({.value = Expression::constant(1.0)})) {
    parameter.has_intercept = false;
  }
  std::erase_if(parameter.covariates, take);
  Expression& formula = model.formula.right;
  formula = formula.substitute(
      parameter.name,
      is_left(parameter) ? Expression::variable(parameter.name) + constant : constant);
}

}  // namespace

std::string no_such_coefficient(const ModelSpecification& specification,
                                std::string_view name,
                                const std::vector<std::string>& known) {
  const std::vector<std::string> columns = specification.formula.right.variables();
  std::string text =
      fmt::format("unknown coefficient '{}'; available: {}", name, fmt::join(known, ", "));
  const auto parameter = std::ranges::find(specification.parameters, name, &ParameterModel::name);
  const bool is_parameter = parameter != specification.parameters.end();
  if (is_parameter && !parameter->has_intercept) {
    text += fmt::format(
        "; the sub-model of {0} has no constant: with one, as in `{0} ~ species` instead of "
        "`{0} ~ species - 1`, a factor gives the same means",
        name);
  }
  const bool is_column = std::ranges::find(columns, name) != columns.end() && !is_parameter;
  if (is_column) {
    text += fmt::format(
        "; '{}' is a column of the data, which stands in the formula instead of a parameter of "
        "this name: rename one of them",
        name);
  }
  return text;
}

void check_known(const ModelSpecification& specification, const std::string& name) {
  const std::vector<std::string> known = specification.coefficient_names();
  if (std::ranges::find(known, name) == known.end()) {
    throw UsageError(no_such_coefficient(specification, name, known));
  }
}

bool has_effects(const ModelSpecification& specification, const std::string& name) {
  return std::ranges::any_of(specification.random, [&](const RandomEffects& term) {
    return std::ranges::find(term.coefficients, name) != term.coefficients.end();
  });
}

ModelSpecification with_constants(const ModelSpecification& specification, const Values& held) {
  for (const auto& [name, value] : held) {
    check_known(specification, name);
    if (!std::isfinite(value))
      throw UsageError(fmt::format("the fixed value of {} is not a number", name));
  }
  ModelSpecification result = specification;
  for (ParameterModel& parameter : result.parameters) {
    hold_in(parameter, held, result);
  }
  std::erase_if(result.parameters, std::not_fn(is_left));
  // Parameters without a fixed effect are last, so that those of pooled() keep their places.
  std::ranges::stable_partition(result.parameters, [](const ParameterModel& parameter) {
    return !parameter.coefficient_names().empty();
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
