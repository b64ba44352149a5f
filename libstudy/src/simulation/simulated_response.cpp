// SPDX-License-Identifier: MIT
#include "simulation/simulated_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "simulation/covariance_root.hpp"

namespace silvafit::study {
namespace {

using data::Expression;

/// `sum + coefficient * covariate`.
Expression with_term(const Expression& sum,
                     const std::string& coefficient,
                     const Expression& covariate) {
  // Names with a blank cannot occur in a formula, so that a substitution cannot change a name of
  // the user.
  static const Expression form = Expression::parse("sum + coefficient*covariate")
                                     .substitute("sum", Expression::variable("the sum"))
                                     .substitute("coefficient", Expression::variable("the factor"))
                                     .substitute("covariate", Expression::variable("the value"));
  return form.substitute("the sum", sum)
      .substitute("the factor", Expression::variable(coefficient))
      .substitute("the value", covariate);
}

/// The mean with each parameter replaced by its sub-model.
Expression mean_of_coefficients(const fit::ModelSpecification& model) {
  // First replaced by names that are invalid in formulas, so that a parameter `a` in the
  // sub-model of `b` is not replaced as well.
  Expression mean = model.formula.right;
  for (const fit::ParameterModel& parameter : model.parameters) {
    mean = mean.substitute(parameter.name, Expression::variable("the " + parameter.name));
  }
  for (const fit::ParameterModel& parameter : model.parameters) {
    const std::vector<std::string> names = parameter.coefficient_names();
    std::size_t next = 0;
    Expression value =
        parameter.has_intercept ? Expression::variable(names[next++]) : Expression::constant(0.0);
    for (const fit::Covariate& covariate : parameter.covariates) {
      value = with_term(value, names[next++], covariate.value);
    }
    mean = mean.substitute("the " + parameter.name, value);
  }
  return mean;
}

Eigen::MatrixXd draw_random_effects(const ResponseDesign& design,
                                    std::size_t plots,
                                    Random& random) {
  const Eigen::Index q = design.random_covariance.rows();
  Eigen::MatrixXd effects = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(plots), q);
  if (q == 0) return effects;
  const auto root = covariance_root(design.random_covariance);
  if (!root)
    throw UsageError("the covariance matrix of the random effects is not positive semidefinite");
  for (Eigen::Index plot = 0; plot < effects.rows(); ++plot) {
    for (Eigen::Index j = 0; j < q; ++j) {
      const double normal = random.normal();
      for (Eigen::Index i = j; i < q; ++i) effects(plot, i) += (*root)(i, j) * normal;
    }
  }
  return effects;
}

}  // namespace

SimulatedResponse::SimulatedResponse(const ResponseDesign& design,
                                     std::size_t plots,
                                     const std::vector<std::size_t>& plot_of_tree,
                                     Random& random)
    : design_(&design), random_effects_(draw_random_effects(design, plots, random)) {
  const std::vector<std::string> names = design.model.coefficient_names();
  const std::vector<std::string> effects = design.model.random.empty()
                                               ? std::vector<std::string>{}
                                               : design.model.random.front().coefficients;
  std::vector<data::Program::Input> inputs;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto effect = std::find(effects.begin(), effects.end(), names[i]);
    std::vector<double>& values = coefficients_.emplace_back();
    for (const std::size_t plot : plot_of_tree) {
      double value = design.fixed[static_cast<Eigen::Index>(i)];
      if (effect != effects.end()) {
        value += random_effects_(static_cast<Eigen::Index>(plot), effect - effects.begin());
      }
      values.push_back(value);
    }
    inputs.push_back({.name = names[i]});
  }
  const std::array<Expression, 1> mean{mean_of_coefficients(design.model)};
  for (const std::string& name : mean[0].variables()) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    variables_.push_back(name);
    inputs.push_back({.name = name});
  }
  program_ = data::Program(mean, std::move(inputs));
}

std::vector<double> SimulatedResponse::means(const Columns& columns) const {
  std::vector<const double*> inputs;
  for (const std::vector<double>& values : coefficients_) inputs.push_back(values.data());
  for (const std::string& name : variables_) inputs.push_back(columns.at(name).data());
  std::vector<double> result(columns.at("dbh").size());
  const std::array<double*, 1> outputs{result.data()};
  data::Program::Workspace workspace;
  program_.evaluate(inputs, result.size(), outputs, workspace);
  for (std::size_t i = 0; i < result.size(); ++i) {
    if (std::isfinite(result[i])) continue;
    throw DomainError(fmt::format("the mean is not finite for a tree with DBH {} cm; check the "
                                  "coefficients and the variances of their random effects",
                                  columns.at("dbh")[i]),
                      {.column = design_->model.formula.text});
  }
  return result;
}

std::vector<double> SimulatedResponse::relative_spread(const std::vector<double>& means,
                                                       const Columns& columns) const {
  using Kind = fit::VarianceFactor::Kind;
  if (design_->model.variance.is_constant()) return std::vector<double>(means.size(), 1.0);
  const fit::VarianceFactor& function = design_->model.variance.factors.front();
  const std::vector<double>& values = function.column.empty() ? means : columns.at(function.column);
  std::vector<double> result;
  result.reserve(values.size());
  for (const double v : values) {
    double spread = 1.0;
    if (function.kind == Kind::kExponential) spread = std::exp(design_->delta * v);
    if (function.kind == Kind::kPower) spread = std::pow(std::abs(v), design_->delta);
    if (function.kind == Kind::kConstantPlusPower) {
      spread = design_->constant + std::pow(std::abs(v), design_->delta);
    }
    result.push_back(spread);
  }
  return result;
}

double SimulatedResponse::sigma(const std::vector<double>& relative_spread) const {
  if (design_->sigma) return *design_->sigma;
  double sum = 0.0;
  for (const double spread : relative_spread) sum += spread * spread;
  const auto count = static_cast<double>(relative_spread.size());
  return sum > 0.0 ? design_->residual_rms.value() / std::sqrt(sum / count) : 0.0;
}

}  // namespace silvafit::study
