// SPDX-License-Identifier: MIT
#include "silvafit/fit/inference_json.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "result/intervals_json.hpp"
#include "silvafit/base/json_values.hpp"

namespace silvafit::fit {
namespace {

using nlohmann::ordered_json;

ordered_json interval(const Interval& value) {
  return {number_or_null(value.low), number_or_null(value.high)};
}

ordered_json reasons(const std::vector<CountedReason>& counted) {
  ordered_json result = ordered_json::array();
  for (const CountedReason& one : counted) {
    result.push_back({{"reason", one.reason}, {"replicates", one.replicates}});
  }
  return result;
}

ordered_json json_of(const ComparedFit& one, const FitNames& names) {
  const FittedModel& fit = *one.fit;
  return {{"name", names.at(&fit)},
          {"model", text_or_null(fit.model)},
          {"method", word_of(fit.method)},
          {"k", fit.parameter_count > 0 ? ordered_json(fit.parameter_count) : ordered_json()},
          {"log_likelihood", number_or_null(fit.log_likelihood)},
          {"aic", number_or_null(fit.aic())},
          {"aicc", number_or_null(fit.aicc())},
          {"bic", number_or_null(fit.bic())},
          {"bic_groups", number_or_null(fit.bic_groups())},
          {"aic_difference", number_or_null(one.aic_difference)},
          {"akaike_weight", number_or_null(one.akaike_weight)}};
}

ordered_json json_of(const ComparedPair& pair,
                     const Comparison& comparison,
                     const FitNames& names) {
  ordered_json result{{"larger", names.at(comparison.fits[pair.larger].fit)},
                      {"smaller", names.at(comparison.fits[pair.smaller].fit)}};
  if (!pair.test) {
    result["why_not"] = pair.reason;
    return result;
  }
  const NestedTest& test = *pair.test;
  result["statistic"] = number_or_null(test.statistic);
  result["df"] = test.degrees_of_freedom;
  result["p_chi_squared"] = number_or_null(test.p_chi_squared);
  result["p"] = number_or_null(test.p);
  result["reference"] = test.reference.text();
  if (!test.note.empty()) result["note"] = test.note;
  return result;
}

}  // namespace

ordered_json json_of(const Bootstrap& bootstrap) {
  ordered_json parameters = ordered_json::object();
  for (const BootstrapParameter& parameter : bootstrap.parameters) {
    parameters[parameter.name] = {{"estimate", number_or_null(parameter.estimate)},
                                  {"replicates", parameter.replicates},
                                  {"bias", number_or_null(parameter.bias)},
                                  {"se", number_or_null(parameter.standard_error)},
                                  {"percentile", interval(parameter.percentile)},
                                  {"basic", interval(parameter.basic)}};
  }
  return {{"resample", word_of(bootstrap.resample)},
          {"seed", bootstrap.seed},
          {"level", bootstrap.level},
          {"replicates", bootstrap.replicates},
          {"converged", bootstrap.converged},
          {"parameters", std::move(parameters)},
          {"failures", reasons(bootstrap.failures)},
          {"boundary", reasons(bootstrap.at_boundary)}};
}

ordered_json json_of(const CrossValidation& result) {
  ordered_json failed = ordered_json::array();
  for (const FailedFold& fold : result.failed) {
    failed.push_back({{"groups", fold.groups}, {"verdict", fold.verdict}});
  }
  ordered_json calibrated = nullptr;
  if (result.measured > 0) {
    calibrated = {{"measured", result.measured},
                  {"predicted", result.calibrated_count},
                  {"statistics", statistics_json(result.calibrated_statistics)},
                  {"population", statistics_json(result.uncalibrated_statistics)}};
  }
  return {{"group", result.group},
          {"groups", result.groups},
          {"folds", result.folds},
          {"seed", result.seed},
          {"predicted", result.predicted_count},
          {"population", statistics_json(result.statistics)},
          {"mean_log_density", number_or_null(result.log_density)},
          {"with_density", result.density_count},
          {"calibrated", std::move(calibrated)},
          {"failed", std::move(failed)}};
}

ordered_json json_of(const Comparison& comparison, const FitNames& names) {
  ordered_json result{{"why_not_comparable", text_or_null(comparison.reason)},
                      {"fits", ordered_json::array()},
                      {"tests", ordered_json::array()},
                      {"not_converged", ordered_json::array()}};
  for (const ComparedFit& one : comparison.fits) result["fits"].push_back(json_of(one, names));
  for (const ComparedPair& pair : comparison.pairs) {
    result["tests"].push_back(json_of(pair, comparison, names));
  }
  for (const FittedModel* const fit : comparison.failed) {
    result["not_converged"].push_back(names.at(fit));
  }
  return result;
}

}  // namespace silvafit::fit
