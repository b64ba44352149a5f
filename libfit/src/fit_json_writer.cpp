// SPDX-License-Identifier: MIT
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "silvafit/fit/fit_json.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using nlohmann::ordered_json;
using Kind = VarianceFunction::Kind;

ordered_json number(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json list(const Eigen::VectorXd& values) {
  ordered_json result = ordered_json::array();
  for (const double value : values) result.push_back(number(value));
  return result;
}

ordered_json rows(const Eigen::MatrixXd& matrix) {
  ordered_json result = ordered_json::array();
  for (Index i = 0; i < matrix.rows(); ++i) result.push_back(list(matrix.row(i)));
  return result;
}

ordered_json parameters(const ModelSpecification& specification) {
  ordered_json result = ordered_json::object();
  for (const ParameterModel& parameter : specification.parameters) {
    if (const std::string text = parameter.text(); text != "1") result[parameter.name] = text;
  }
  return result;
}

ordered_json groups(const FittedModel& fit) {
  ordered_json result = ordered_json::object();
  if (fit.has_random_effects()) {
    result[fit.specification.random->group] = fit.group_labels.size();
  }
  return result;
}

ordered_json evidence(const Convergence& convergence) {
  return {{"gradient", number(convergence.gradient)},
          {"iterations", convergence.iterations},
          {"boundary", convergence.boundary},
          {"rank", convergence.rank}};
}

ordered_json fixed(const FittedModel& fit) {
  const Eigen::VectorXd errors = fit.standard_errors();
  const Eigen::VectorXd t = fit.t_values();
  const Eigen::VectorXd p = fit.p_values();
  ordered_json result = ordered_json::object();
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const auto j = static_cast<Index>(k);
    result[fit.coefficient_names[k]] = {{"estimate", number(fit.estimate[j])},
                                        {"se", number(errors[j])},
                                        {"df", number(fit.degrees_of_freedom)},
                                        {"t", number(t[j])},
                                        {"p", number(p[j])}};
  }
  return result;
}

ordered_json eblups(const FittedModel& fit) {
  ordered_json result = ordered_json::object();
  for (std::size_t g = 0; g < fit.group_labels.size(); ++g) {
    ordered_json& group = result[fit.group_labels[g]];
    for (std::size_t k = 0; k < fit.random_names.size(); ++k) {
      group[fit.random_names[k]] =
          number(fit.random_effects(static_cast<Index>(k), static_cast<Index>(g)));
    }
  }
  return result;
}

ordered_json random(const FittedModel& fit) {
  if (!fit.has_random_effects()) return nullptr;
  return {{"group", fit.specification.random->group},
          {"effects", fit.random_names},
          {"form", covariance_text(fit.specification.covariance)},
          {"covariance", rows(fit.random_covariance)},
          {"sd", list(fit.random_sd())},
          {"correlation", rows(fit.random_correlation())},
          {"eblup", eblups(fit)}};
}

ordered_json variance(const VarianceEstimate& estimate) {
  const VarianceFunction& function = estimate.function;
  const bool has_delta = function.kind != Kind::kNone;
  const bool has_constant = function.kind == Kind::kConstantPlusPower;
  ordered_json of = nullptr;
  if (has_delta) of = function.column.empty() ? "fitted" : function.column;
  return {{"function", VarianceFunction{.kind = function.kind}.text()},
          {"of", std::move(of)},
          {"delta", has_delta ? number(estimate.delta) : ordered_json(nullptr)},
          {"constant", has_constant ? number(estimate.constant) : ordered_json(nullptr)}};
}

ordered_json statistics(const FitStatistics& values) {
  return {{"r2", number(values.r2)},
          {"mean_error", number(values.mean_error)},
          {"rmse", number(values.rmse)},
          {"mae", number(values.mae)}};
}

ordered_json ranges(const FittedModel& fit) {
  ordered_json result = ordered_json::object();
  for (const ColumnRange& range : fit.ranges) {
    result[range.column] = {number(range.low), number(range.high)};
  }
  return result;
}

ordered_json text_or_null(const std::string& text) {
  return text.empty() ? ordered_json(nullptr) : ordered_json(text);
}

}  // namespace

std::string to_json(const FittedModel& fit, int indent) {
  const ordered_json result{
      {"schema", "silvafit-fit/1"},
      {"silvafit", SILVAFIT_VERSION},
      {"model", text_or_null(fit.model)},
      {"formula", fit.specification.formula.text},
      {"parameters", parameters(fit.specification)},
      {"method", method_text(fit.method)},
      {"reml", false},
      {"n", fit.observations},
      {"excluded", fit.excluded},
      {"groups", groups(fit)},
      {"converged", fit.convergence.converged},
      {"verdict", fit.convergence.verdict},
      {"evidence", evidence(fit.convergence)},
      {"fixed", fixed(fit)},
      {"fixed_covariance", rows(fit.covariance)},
      {"random", random(fit)},
      {"variance", variance(fit.variance)},
      {"sigma", number(fit.sigma)},
      {"log_likelihood", number(fit.log_likelihood)},
      {"k", fit.parameter_count > 0 ? ordered_json(fit.parameter_count) : ordered_json(nullptr)},
      {"aic", number(fit.aic())},
      {"aicc", number(fit.aicc())},
      {"bic", number(fit.bic())},
      {"statistics",
       {{"population", statistics(fit.population)},
        {"conditional",
         fit.has_random_effects() ? statistics(fit.conditional) : ordered_json(nullptr)}}},
      {"ranges", ranges(fit)},
      {"seconds", number(fit.seconds)}};
  return result.dump(indent);
}

}  // namespace silvafit::fit
