// SPDX-License-Identifier: MIT
#include "fitted_model/constrained_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"

namespace silvafit::fit {
namespace {

using data::Expression;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Values = std::map<std::string, double>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void check_coefficient(const ModelSpecification& specification, const std::string& name) {
  const std::vector<std::string> known = specification.coefficient_names();
  if (std::ranges::find(known, name) == known.end()) {
    throw UsageError(fmt::format(
        "'{}' is no coefficient of the model; there are {}", name, fmt::join(known, ", ")));
  }
  for (const auto& random : {specification.random, specification.outer_random}) {
    if (!random || std::ranges::find(random->coefficients, name) == random->coefficients.end()) {
      continue;
    }
    throw UsageError(fmt::format(
        "{} has a random effect by {}; it can be neither held nor bounded", name, random->group));
  }
}

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

/// The result of the model with held coefficients, described as that of the whole model.
FitResult expanded(FitResult result, const ModelSpecification& whole, const Values& held) {
  FittedModel& fit = result.fit;
  const std::vector<std::string> names = whole.coefficient_names();
  const auto p = static_cast<Index>(names.size());
  VectorXd estimate(p);
  MatrixXd covariance = MatrixXd::Constant(p, p, kNaN);
  std::vector<Index> places;
  for (Index j = 0; j < p; ++j) {
    const auto found = held.find(names[static_cast<std::size_t>(j)]);
    if (found == held.end()) {
      estimate[j] = fit.estimate[static_cast<Index>(places.size())];
      places.push_back(j);
    } else {
      estimate[j] = found->second;
    }
  }
  covariance(places, places) = fit.covariance;
  VectorXd freedom = VectorXd::Constant(p, kNaN);
  freedom(places) = fit.degrees_of_freedom;
  fit.degrees_of_freedom = std::move(freedom);
  fit.estimate = std::move(estimate);
  fit.covariance = std::move(covariance);
  fit.coefficient_names = names;
  fit.specification = whole;
  return result;
}

/// Coefficients and the bounds that they are held at.
class ActiveBounds {
 public:
  ActiveBounds(const ModelSpecification& specification,
               const FitModelOptions& options,
               const FreeFit& fit)
      : specification_(specification), options_(options), fit_(fit) {}

  FitResult run() {
    FitResult result = fit_with(at_bound_);
    const std::size_t rounds = 2 * options_.bounds.size() + 1;
    for (std::size_t round = 0; round < rounds && result.fit.convergence.converged; ++round) {
      if (const auto crossed = most_crossed(result.fit)) {
        at_bound_[crossed->first] = crossed->second;
      } else if (!release_one()) {
        break;
      }
      result = fit_with(at_bound_);
    }
    describe(result.fit);
    return result;
  }

 private:
  FitResult fit_with(const Values& at_bound) const {
    Values held = options_.fixed;
    held.insert(at_bound.begin(), at_bound.end());
    return expanded(fit_(with_held(specification_, held)), specification_, held);
  }

  /// The coefficient that is furthest outside its bounds, in standard errors, and its bound.
  std::optional<std::pair<std::string, double>> most_crossed(const FittedModel& fit) const {
    const VectorXd errors = fit.standard_errors();
    std::optional<std::pair<std::string, double>> worst;
    double largest = 0.0;
    for (const auto& [name, bounds] : options_.bounds) {
      const Index j =
          std::ranges::find(fit.coefficient_names, name) - fit.coefficient_names.begin();
      const double value = fit.estimate[j];
      const double bound = std::clamp(value, bounds.low, bounds.high);
      if (at_bound_.contains(name) || bound == value) continue;
      const double excess = std::abs(value - bound) / (errors[j] > 0.0 ? errors[j] : 1.0);
      if (excess <= largest && worst) continue;
      worst = {name, bound};
      largest = excess;
    }
    return worst;
  }

  /// With several coefficients at their bounds, one may be free to come back inside.
  bool release_one() {
    if (at_bound_.size() < 2) return false;
    for (const auto& [name, bound] : at_bound_) {
      Values fewer = at_bound_;
      fewer.erase(name);
      const FittedModel fit = fit_with(fewer).fit;
      const Index j =
          std::ranges::find(fit.coefficient_names, name) - fit.coefficient_names.begin();
      const Bounds& bounds = options_.bounds.at(name);
      const bool is_inside = fit.estimate[j] > bounds.low && fit.estimate[j] < bounds.high;
      if (!fit.convergence.converged || !is_inside) continue;
      at_bound_ = std::move(fewer);
      return true;
    }
    return false;
  }

  void describe(FittedModel& fit) const {
    std::vector<std::string> names;
    for (const auto& [name, bound] : at_bound_) {
      names.push_back(fmt::format("{} = {}, its bound", name, data::shortest(bound)));
    }
    if (names.empty()) return;
    if (fit.parameter_count > 0) fit.parameter_count += static_cast<int>(names.size());
    fit.convergence.verdict += fmt::format(" Held at a bound: {}.", fmt::join(names, "; "));
    auto& boundary = fit.convergence.boundary;
    boundary.insert(boundary.end(), names.begin(), names.end());
  }

  const ModelSpecification& specification_;
  const FitModelOptions& options_;
  const FreeFit& fit_;
  Values at_bound_;
};

}  // namespace

ModelSpecification with_held(const ModelSpecification& specification, const Values& held) {
  for (const auto& [name, value] : held) {
    check_coefficient(specification, name);
    if (!std::isfinite(value)) throw UsageError(fmt::format("{} is held at no number", name));
  }
  ModelSpecification result = specification;
  for (ParameterModel& parameter : result.parameters) {
    hold_in(parameter, held, result.formula.right);
  }
  std::erase_if(result.parameters, [](const ParameterModel& parameter) {
    return !parameter.has_intercept && parameter.covariates.empty();
  });
  if (result.parameters.empty()) {
    throw UsageError("all coefficients are held, so that there is nothing to estimate");
  }
  return result;
}

FitResult fit_constrained(const ModelSpecification& specification,
                          const FitModelOptions& options,
                          const FreeFit& fit) {
  for (const auto& [name, bounds] : options.bounds) {
    check_coefficient(specification, name);
    if (!(bounds.low < bounds.high)) {
      throw UsageError(fmt::format("the bounds of {} leave nothing between them", name));
    }
    if (options.fixed.contains(name)) {
      throw UsageError(fmt::format("{} is both held and bounded", name));
    }
  }
  return ActiveBounds(specification, options, fit).run();
}

}  // namespace silvafit::fit
