// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "json_value.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/fit_json.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Kind = VarianceFunction::Kind;

/// What a text of the file means; complaints about the text get the place of its key.
template <class Parse>
auto read_with(const JsonValue& json, Parse parse) {
  const std::string text = json.text();
  try {
    return parse(text);
  } catch (const UsageError& error) {
    json.fail(error.message());
  }
}

void check_schema(const JsonValue& json) {
  constexpr std::string_view kPrefix = "silvafit-fit/";
  const std::string schema = json.text();
  if (schema == "silvafit-fit/1") return;
  if (schema.starts_with(kPrefix)) {
    json.fail(fmt::format("{} is from a newer silvafit than this ({}), which reads silvafit-fit/1",
                          schema,
                          SILVAFIT_VERSION));
  }
  json.fail(fmt::format("must be silvafit-fit/1, is \"{}\"", schema));
}

/// Names of the formula that have a sub-model or an estimate are its parameters; the others are
/// columns.
ModelSpecification read_specification(const JsonValue& json) {
  ModelSpecification specification{
      .formula = read_with(json.at("formula"),
                           [](const std::string& text) { return data::parse_formula(text); })};
  const JsonValue sub_models = json.at("parameters");
  const JsonValue fixed = json.at("fixed");
  for (const std::string& name : specification.formula.right.variables()) {
    if (sub_models.has(name)) {
      specification.parameters.push_back(
          read_with(sub_models.at(name), [&name](const std::string& text) {
            ParameterModel model = parse_parameter_model("p ~ " + text);
            model.name = name;
            return model;
          }));
    } else if (fixed.has(name)) {
      specification.parameters.push_back({.name = name});
    }
  }
  return specification;
}

void read_fixed(const JsonValue& json, FittedModel& fit) {
  fit.coefficient_names = fit.specification.coefficient_names();
  const JsonValue fixed = json.at("fixed");
  if (fixed.members().size() != fit.coefficient_names.size()) {
    fixed.fail(fmt::format("must name the coefficients of the formula: {}",
                           fmt::join(fit.coefficient_names, ", ")));
  }
  const auto p = static_cast<Index>(fit.coefficient_names.size());
  fit.estimate.resize(p);
  for (Index j = 0; j < p; ++j) {
    const JsonValue coefficient = fixed.at(fit.coefficient_names[static_cast<std::size_t>(j)]);
    fit.estimate[j] = coefficient.at("estimate").number();
    fit.degrees_of_freedom = coefficient.at("df").number();
  }
  fit.covariance = json.at("fixed_covariance").square_matrix(p);
}

void read_random(const JsonValue& json, FittedModel& fit) {
  if (json.is_null()) return;
  fit.specification.random =
      RandomEffects{.coefficients = json.at("effects").texts(), .group = json.at("group").text()};
  fit.specification.covariance = read_with(json.at("form"), parse_covariance);
  fit.random_names = fit.specification.random->coefficients;
  for (const JsonValue& effect : json.at("effects").items()) {
    if (std::ranges::find(fit.coefficient_names, effect.text()) == fit.coefficient_names.end()) {
      effect.fail(fmt::format("'{}' is no coefficient of the model", effect.text()));
    }
  }
  const auto q = static_cast<Index>(fit.random_names.size());
  fit.random_covariance = json.at("covariance").square_matrix(q);
  const auto groups = json.at("eblup").members();
  fit.random_effects.resize(q, static_cast<Index>(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    fit.group_labels.push_back(groups[g].first);
    for (Index k = 0; k < q; ++k) {
      fit.random_effects(k, static_cast<Index>(g)) =
          groups[g].second.at(fit.random_names[static_cast<std::size_t>(k)]).number();
    }
  }
}

VarianceEstimate read_variance(const JsonValue& json) {
  VarianceEstimate result{.function = read_with(json.at("function"), parse_variance_function)};
  const Kind kind = result.function.kind;
  if (kind == Kind::kNone) return result;
  if (const std::string of = json.at("of").text(); of != "fitted") result.function.column = of;
  result.delta = json.at("delta").number();
  if (kind != Kind::kConstantPlusPower) return result;
  // An infinite constant, that of a variance which has become constant, is written as null.
  const double constant = json.at("constant").number();
  const bool is_infinite = std::isnan(constant) && std::isfinite(result.delta);
  result.constant = is_infinite ? std::numeric_limits<double>::infinity() : constant;
  return result;
}

FitStatistics read_statistics(const JsonValue& json) {
  return {.r2 = json.at("r2").number(),
          .mean_error = json.at("mean_error").number(),
          .rmse = json.at("rmse").number(),
          .mae = json.at("mae").number()};
}

Convergence read_convergence(const JsonValue& json) {
  const JsonValue evidence = json.at("evidence");
  return {.converged = json.at("converged").boolean(),
          .verdict = json.at("verdict").text(),
          .gradient = evidence.at("gradient").number(),
          .iterations = evidence.at("iterations").count(),
          .rank = evidence.at("rank").count(),
          .boundary = evidence.at("boundary").texts()};
}

std::vector<ColumnRange> read_ranges(const JsonValue& json) {
  std::vector<ColumnRange> ranges;
  for (const auto& [column, limits] : json.members()) {
    const Eigen::VectorXd values = limits.vector(2);
    ranges.push_back({.column = column, .low = values[0], .high = values[1]});
  }
  return ranges;
}

}  // namespace

FittedModel from_json(std::string_view text, const std::string& file, const std::string& key) {
  const JsonValue json = JsonValue::parse(text, file, key);
  check_schema(json.at("schema"));
  FittedModel fit{.specification = read_specification(json)};
  if (!json.at("model").is_null()) fit.model = json.at("model").text();
  fit.method = read_with(json.at("method"), parse_method);
  fit.observations = json.at("n").count();
  fit.excluded = json.at("excluded").count();
  fit.convergence = read_convergence(json);
  read_fixed(json, fit);
  read_random(json.at("random"), fit);
  fit.variance = read_variance(json.at("variance"));
  fit.specification.variance = fit.variance.function;
  fit.sigma = json.at("sigma").number();
  fit.log_likelihood = json.at("log_likelihood").number();
  if (!json.at("k").is_null()) fit.parameter_count = json.at("k").count();
  const JsonValue statistics = json.at("statistics");
  fit.population = read_statistics(statistics.at("population"));
  const JsonValue conditional = statistics.at("conditional");
  fit.conditional = conditional.is_null() ? fit.population : read_statistics(conditional);
  fit.ranges = read_ranges(json.at("ranges"));
  fit.seconds = json.at("seconds").number();
  return fit;
}

}  // namespace silvafit::fit
