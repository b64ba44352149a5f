// SPDX-License-Identifier: MIT
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "result/intervals_json.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/fit/conditional_errors.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {
namespace {

using nlohmann::ordered_json;

constexpr const char* kSchema = "silvafit-fit/2";

ordered_json list(const VectorXd& values) {
  ordered_json result = ordered_json::array();
  for (const double value : values) result.push_back(number_or_null(value));
  return result;
}

ordered_json rows(const MatrixXd& matrix) {
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
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    result[fit.specification.random[k].group_name()] = fit.random[k].labels.size();
  }
  return result;
}

ordered_json optima(const FittedModel& fit) {
  ordered_json result = ordered_json::array();
  for (const LocalOptimum& optimum : fit.optima) {
    ordered_json fixed = ordered_json::object();
    for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
      fixed[fit.coefficient_names[j]] = number_or_null(optimum.estimate[static_cast<Index>(j)]);
    }
    result.push_back({{"origin", optimum.origin},
                      {"log_likelihood", number_or_null(optimum.log_likelihood)},
                      {"marginal_log_likelihood", number_or_null(optimum.marginal_log_likelihood)},
                      {"fixed", std::move(fixed)}});
  }
  return result;
}

ordered_json evidence(const Convergence& convergence) {
  ordered_json findings = ordered_json::array();
  for (const Evidence& item : convergence.evidence) {
    findings.push_back(
        {{"kind", word_of(item.kind)}, {"term", item.term}, {"value", number_or_null(item.value)}});
  }
  return {{"gradient", number_or_null(convergence.newton_decrement)},
          {"iterations", convergence.iterations},
          {"boundary", convergence.boundary()},
          {"rank", convergence.rank},
          {"findings", std::move(findings)}};
}

ordered_json fixed(const FittedModel& fit) {
  const VectorXd errors = fit.standard_errors();
  const VectorXd t = fit.t_values();
  const VectorXd p = fit.p_values();
  ordered_json result = ordered_json::object();
  for (std::size_t k = 0; k < fit.coefficient_names.size(); ++k) {
    const auto j = static_cast<Index>(k);
    result[fit.coefficient_names[k]] = {
        {"estimate", number_or_null(fit.estimate[j])},
        {"se", number_or_null(errors[j])},
        {"df", number_or_null(j < fit.degrees_of_freedom.size() ? fit.degrees_of_freedom[j] : NAN)},
        {"t", number_or_null(t[j])},
        {"p", number_or_null(p[j])}};
  }
  return result;
}

ordered_json derived(const FittedModel& fit) {
  ordered_json result = ordered_json::object();
  const std::vector<DerivedValue> values = derived_values(fit);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const DerivedQuantity& quantity = fit.specification.derived[k];
    result[quantity.name] = {{"expression", quantity.value.text()},
                             {"estimate", number_or_null(values[k].estimate)},
                             {"se", number_or_null(values[k].standard_error)},
                             {"df", number_or_null(values[k].degrees_of_freedom)}};
  }
  return result;
}

/// An object with a member for each group. Labels are distinct, so that no search for an existing
/// member is needed.
template <class ValueOf>
ordered_json by_label(const std::vector<std::string>& labels, ValueOf value_of) {
  ordered_json::object_t result;
  result.reserve(labels.size());
  for (std::size_t g = 0; g < labels.size(); ++g) {
    result.push_back({labels[g], value_of(static_cast<Index>(g))});
  }
  return result;
}

ordered_json eblups(const std::vector<std::string>& labels,
                    const std::vector<std::string>& names,
                    const MatrixXd& effects) {
  return by_label(labels, [&](Index g) {
    ordered_json group = ordered_json::object();
    for (std::size_t k = 0; k < names.size(); ++k) {
      group[names[k]] = number_or_null(effects(static_cast<Index>(k), g));
    }
    return group;
  });
}

/// Matrices of each group, stored column by column, by label.
ordered_json matrices(const std::vector<std::string>& labels,
                      const MatrixXd& values,
                      Index rows_each) {
  return by_label(labels, [&](Index g) {
    const auto column = values.col(g);
    return rows(column.reshaped(rows_each, column.size() / rows_each));
  });
}

void add_uncertainty(const EstimatedEffects& term, ordered_json& result) {
  const EffectUncertainty& uncertainty = term.uncertainty;
  if (!uncertainty.is_known()) return;
  const Index size = term.effects.rows();
  result["eblup_se"] = eblups(term.labels, term.names, conditional_errors(uncertainty, size));
  result["eblup_covariance"] = matrices(term.labels, uncertainty.covariances, size);
  result["eblup_by_fixed"] = matrices(term.labels, uncertainty.sensitivities, size);
}

ordered_json random_term(const RandomEffects& specification, const EstimatedEffects& term) {
  ordered_json result{{"group", specification.group},
                      {"effects", specification.coefficients},
                      {"form", word_of(specification.covariance)}};
  // Only of crossed terms; the second of two nested ones is within the first.
  if (specification.is_crossed) result["within"] = specification.within;
  if (specification.covariance == Covariance::kBlock) result["blocks"] = specification.blocks;
  result["covariance"] = rows(term.covariance);
  result["sd"] = list(term.sd());
  result["correlation"] = rows(term.correlation());
  result["eblup"] = eblups(term.labels, term.names, term.effects);
  add_uncertainty(term, result);
  return result;
}

ordered_json random(const FittedModel& fit) {
  ordered_json result = ordered_json::array();
  for (std::size_t k = 0; k < fit.random.size(); ++k) {
    result.push_back(random_term(fit.specification.random[k], fit.random[k]));
  }
  return result;
}

/// The cells of the groups of several terms.
ordered_json cells(const FittedModel& fit) {
  ordered_json groups = ordered_json::array();
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    ordered_json& of_term = groups.emplace_back(ordered_json::array());
    for (const Index group : fit.cells.groups[t]) {
      of_term.push_back(fit.random[t].labels[static_cast<std::size_t>(group)]);
    }
  }
  return {{"groups", std::move(groups)}, {"curvature", rows(fit.cells.curvatures.transpose())}};
}

/// Parameters of a factor that has strata, by stratum.
ordered_json by_stratum(const VarianceFactorEstimate& factor, const VectorXd& values) {
  if (values.size() == 0) return nullptr;
  if (factor.factor.stratum.empty()) return number_or_null(values[0]);
  ordered_json result = ordered_json::object();
  for (std::size_t s = 0; s < factor.strata.size(); ++s) {
    result[factor.strata[s]] = number_or_null(values[static_cast<Index>(s)]);
  }
  return result;
}

ordered_json variance_factor(const VarianceFactorEstimate& estimate) {
  const VarianceFactor& factor = estimate.factor;
  ordered_json result{{"function", VarianceFactor{.kind = factor.kind}.text()},
                      {"of", factor.column.empty() ? "fitted" : factor.column}};
  if (!kind_of(factor).reads_value()) result["of"] = nullptr;
  if (!factor.stratum.empty()) result["strata"] = factor.stratum;
  result["delta"] = by_stratum(estimate, estimate.delta);
  result["constant"] = by_stratum(estimate, estimate.constant);
  if (!kind_of(factor).has_delta()) result["ratio"] = by_stratum(estimate, estimate.ratio);
  std::vector<std::string> held;
  if (factor.delta) held.emplace_back("delta");
  if (factor.constant) held.emplace_back("constant");
  if (!held.empty()) result["held"] = held;
  return result;
}

ordered_json variance(const VarianceEstimate& estimate) {
  if (estimate.factors.empty()) {
    return {{"function", "none"}, {"of", nullptr}, {"delta", nullptr}, {"constant", nullptr}};
  }
  if (estimate.factors.size() == 1) return variance_factor(estimate.factors.front());
  ordered_json factors = ordered_json::array();
  for (const VarianceFactorEstimate& factor : estimate.factors) {
    factors.push_back(variance_factor(factor));
  }
  return {{"function", estimate.function().text()},
          {"of", nullptr},
          {"delta", nullptr},
          {"constant", nullptr},
          {"factors", std::move(factors)}};
}

/// Without parameters of a fit that failed.
ordered_json correlation(const FittedModel& fit) {
  ordered_json result{{"structure", fit.specification.correlation->text()}};
  ordered_json& values = result["parameters"] = ordered_json::object();
  const auto& estimate = fit.variance.correlation;
  if (!estimate) return result;
  for (std::size_t k = 0; k < estimate->names.size(); ++k) {
    values[estimate->names[k]] = number_or_null(estimate->values[static_cast<Index>(k)]);
  }
  if (!estimate->times.empty()) result["times"] = estimate->times;
  result["unit"] = number_or_null(estimate->unit);
  result["largest_group"] = estimate->largest;
  return result;
}

ordered_json ranges(const FittedModel& fit) {
  ordered_json result = ordered_json::object();
  for (const ColumnRange& range : fit.ranges) {
    result[range.column] = {number_or_null(range.low), number_or_null(range.high)};
  }
  return result;
}

ordered_json levels(const FittedModel& fit) {
  ordered_json result = ordered_json::object();
  for (const ColumnLevels& levels : fit.levels) result[levels.column] = levels.labels;
  return result;
}

}  // namespace

ordered_json json_of(const FittedModel& fit) {
  ordered_json result{
      {"schema", kSchema},
      {"silvafit", SILVAFIT_VERSION},
      {"model", text_or_null(fit.model)},
      {"formula", fit.specification.formula.text},
      {"parameters", parameters(fit.specification)},
      {"method", word_of(fit.method)},
      {"reml", fit.reml},
      {"n", fit.observations},
      {"excluded", fit.excluded},
      {"response_fingerprint", text_or_null(fit.response_fingerprint)},
      {"groups", groups(fit)},
      {"converged", fit.convergence.converged()},
      {"status", word_of(fit.convergence.status)},
      {"verdict", fit.convergence.verdict()},
      {"evidence", evidence(fit.convergence)},
      {"fixed", fixed(fit)},
      {"fixed_covariance", rows(fit.covariance)},
      {"random", random(fit)},
      {"variance", variance(fit.variance)},
      {"sigma", number_or_null(fit.sigma)},
      {"log_likelihood", number_or_null(fit.log_likelihood)},
      {"k", fit.parameter_count > 0 ? ordered_json(fit.parameter_count) : ordered_json(nullptr)},
      {"aic", number_or_null(fit.aic())},
      {"aicc", number_or_null(fit.aicc())},
      {"bic", number_or_null(fit.bic())},
      {"bic_groups", number_or_null(fit.bic_groups())},
      {"statistics",
       {{"population", statistics_json(fit.population)},
        {"conditional",
         fit.has_random_effects() ? statistics_json(fit.conditional) : ordered_json(nullptr)}}},
      {"r2_marginal", number_or_null(fit.r2_marginal)},
      {"r2_conditional", number_or_null(fit.r2_conditional)},
      {"ranges", ranges(fit)},
      {"seconds", number_or_null(fit.seconds)}};
  if (!fit.cells.groups.empty()) result["random_cells"] = cells(fit);
  if (fit.specification.correlation) result["correlation"] = correlation(fit);
  if (!fit.levels.empty()) result["levels"] = levels(fit);
  if (!fit.specification.factors.empty()) result["factors"] = fit.specification.factors;
  if (!fit.specification.derived.empty()) result["derived"] = derived(fit);
  if (!fit.coefficients_between.empty()) result["coefficients_between"] = fit.coefficients_between;
  if (fit.quadrature_points > 0) result["agq_points"] = fit.quadrature_points;
  if (!fit.optima.empty()) result["optima"] = optima(fit);
  if (fit.intervals) result["intervals"] = intervals_json(*fit.intervals);
  return result;
}

std::string to_json(const FittedModel& fit, int indent) { return json_text(json_of(fit), indent); }

}  // namespace silvafit::fit
