// SPDX-License-Identifier: MIT
// Fits and derived results.
#include <algorithm>
#include <array>
#include <cpp11/list.hpp>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "background.hpp"
#include "conditions.hpp"
#include "conversion.hpp"
#include "entry_points.hpp"
#include "fit_handle.hpp"
#include "handle.hpp"
#include "settings.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/intervals.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/fit/residuals.hpp"
#include "silvafit/fit/setting_list.hpp"
#include "silvafit/fit/simulated_responses.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::r {
namespace {

/// Kinds of parameters, in the order of the enumeration.
constexpr std::array<const char*, 6> kKinds{
    "fixed", "sd", "cor", "variance", "sigma", "correlation"};

fit::ModelTexts model_texts(const Arguments& model) {
  auto texts = settings_of<fit::ModelTexts>(model);
  model.read("columns", texts.columns);
  return texts;
}

/// The model, with the factors whose columns the R functions have turned into comparisons.
/// \param options  get the start values of a model of the catalogue
fit::ModelSpecification specification_of(const Arguments& model,
                                         const data::Table& table,
                                         fit::FitModelOptions& options) {
  fit::ModelTexts texts = model_texts(model);
  if (model.has("model")) {
    const auto catalogue = study::Catalogue::load(data_folder(model) / "models");
    study::use_base_model(catalogue.find(text_of(model["model"])), table, texts, options);
  }
  fit::ModelSpecification specification = fit::specify_model(texts, table);
  for (const std::string& factor : texts_of(model["factors"])) {
    if (std::ranges::find(specification.factors, factor) == specification.factors.end()) {
      specification.factors.push_back(factor);
    }
  }
  return specification;
}

/// Puts the results of a fit in the order of the table's rows.
void sort_rows(fit::FitResult& result) {
  std::vector<Eigen::Index> order(result.rows.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::ranges::sort(
      order, {}, [&](Eigen::Index i) { return result.rows[static_cast<std::size_t>(i)]; });
  for (Eigen::VectorXd* const values :
       {&result.fitted_population, &result.fitted_conditional, &result.residual_sd}) {
    // A fit that failed has none.
    if (values->size() == static_cast<Eigen::Index>(order.size())) {
      *values = (*values)(order).eval();
    }
  }
  std::ranges::sort(result.rows);
}

cpp11::sexp list_of(const fit::Prediction& prediction) {
  NamedList list;
  list.add("value", value_of(prediction.value));
  list.add("lower", value_of(prediction.lower));
  list.add("upper", value_of(prediction.upper));
  list.add("mean_error", value_of(prediction.mean_error));
  list.add("prediction_error", value_of(prediction.prediction_error));
  list.add("df", value_of(prediction.degrees_of_freedom));
  list.add("residual_sd", value_of(prediction.residual_sd));
  std::vector<double> is_new(prediction.is_new_group.begin(), prediction.is_new_group.end());
  list.add("is_new_group", value_of(is_new));
  std::vector<double> calibrated(prediction.calibrated_from.begin(),
                                 prediction.calibrated_from.end());
  list.add("calibrated_from", value_of(calibrated));
  return list.list();
}

cpp11::sexp list_of(const fit::Intervals& intervals) {
  std::vector<std::string> names;
  std::vector<std::string> kinds;
  std::vector<std::string> notes;
  std::vector<double> estimate;
  std::vector<double> lower;
  std::vector<double> upper;
  for (const fit::ParameterInterval& one : intervals.parameters) {
    names.push_back(one.name);
    kinds.push_back(kKinds.at(static_cast<std::size_t>(one.kind)));
    notes.push_back(one.note);
    estimate.push_back(one.estimate);
    lower.push_back(one.lower);
    upper.push_back(one.upper);
  }
  NamedList list;
  list.add("name", value_of(names));
  list.add("kind", value_of(kinds));
  list.add("estimate", value_of(estimate));
  list.add("lower", value_of(lower));
  list.add("upper", value_of(upper));
  list.add("note", value_of(notes));
  list.add("likelihood", value_of(intervals.likelihood));
  return list.list();
}

nlohmann::ordered_json json_of(const fit::ComparedPair& pair) {
  nlohmann::ordered_json result{{"larger", pair.larger + 1}, {"smaller", pair.smaller + 1}};
  if (!pair.test) {
    result["reason"] = pair.reason;
    return result;
  }
  result["statistic"] = pair.test->statistic;
  result["df"] = pair.test->degrees_of_freedom;
  result["p_chi_squared"] = pair.test->p_chi_squared;
  result["p"] = pair.test->p;
  result["note"] = pair.test->note;
  return result;
}

/// \param fits  those compared, in the order of R
cpp11::sexp list_of(const fit::Comparison& comparison,
                    const std::vector<const fit::FittedModel*>& fits) {
  const auto number_of_fit = [&](const fit::FittedModel* fit) {
    return std::ranges::find(fits, fit) - fits.begin() + 1;
  };
  nlohmann::ordered_json result{{"order", nlohmann::ordered_json::array()},
                                {"aic_difference", nlohmann::ordered_json::array()},
                                {"weight", nlohmann::ordered_json::array()},
                                {"tests", nlohmann::ordered_json::array()},
                                {"failed", nlohmann::ordered_json::array()},
                                {"reason", comparison.reason}};
  for (const fit::ComparedFit& one : comparison.fits) {
    result["order"].push_back(number_of_fit(one.fit));
    result["aic_difference"].push_back(one.aic_difference);
    result["weight"].push_back(one.akaike_weight);
  }
  for (const fit::ComparedPair& pair : comparison.pairs) result["tests"].push_back(json_of(pair));
  for (const fit::FittedModel* const fit : comparison.failed) {
    result["failed"].push_back(number_of_fit(fit));
  }
  return value_of(result);
}

}  // namespace

SEXP text_of_fit(SEXP handle) { return json_of(handle); }

SEXP fit_model(SEXP columns, SEXP model, SEXP option_list) {
  const data::Table table = table_of(cpp11::list(columns));
  const Arguments texts(model);
  const Arguments arguments(option_list);
  fit::FitModelOptions options = fit_options(arguments);
  const fit::ModelSpecification specification = specification_of(texts, table, options);
  bool is_traced = false;
  arguments.read("trace", is_traced);
  std::optional<fit::FitResult> fitted;
  const std::clock_t start = std::clock();
  run_in_background(
      [&](Reports& reports) {
        options.stop = reports.stop();
        if (is_traced) {
          options.trace = [&reports](const std::string& line) { reports.print(line); };
        }
        fitted = fit::fit_model(specification, table, options);
      },
      false);
  // CPU time of the fit itself, which benchmarks compare with that of the whole call.
  const double cpu_seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  fit::FitResult& result = *fitted;
  texts.read("model", result.fit.model);
  sort_rows(result);
  NamedList list;
  list.add("model", list_of_fit(std::move(result.fit)));
  list.add("rows", row_numbers(result.rows));
  list.add("population", value_of(result.fitted_population));
  list.add("conditional", value_of(result.fitted_conditional));
  list.add("residual_sd", value_of(result.residual_sd));
  list.add("cpu_seconds", value_of(std::vector<double>{cpu_seconds}));
  return list.list();
}

SEXP formula_of_model(SEXP id, SEXP folder) {
  const std::filesystem::path models = std::filesystem::path(text_of(folder)) / "models";
  return value_of(study::Catalogue::load(models).find(text_of(id)).formula);
}

SEXP read_fit(SEXP json, SEXP file) {
  return list_of_fit(fit::from_json(text_of(json), text_of(file)));
}

SEXP with_estimates(SEXP handle, SEXP estimates) {
  fit::FittedModel fit = fit_of(handle);
  const std::vector<double> values = numbers_of(estimates);
  if (static_cast<Eigen::Index>(values.size()) != fit.estimate.size()) {
    throw UsageError("the fit has " + std::to_string(fit.estimate.size()) + " fixed effects");
  }
  fit.estimate = Eigen::Map<const Eigen::VectorXd>(values.data(), fit.estimate.size());
  const std::string json = json_text(fit::json_of(fit));
  return handle_of(std::move(fit), json);
}

SEXP rows_of_fit(SEXP handle, SEXP columns) {
  const fit::FittedModel& fit = fit_of(handle);
  const data::Table table = table_of(cpp11::list(columns));
  const fit::Residuals residuals = fit::residuals(fit, table);
  NamedList list;
  list.add("rows", row_numbers(residuals.rows));
  list.add("observed", value_of(residuals.observed));
  list.add("population", value_of(residuals.population.fitted));
  list.add("conditional", value_of(residuals.conditional.fitted));
  list.add("residual_sd",
           value_of(fit.residual_sd(residuals.conditional.fitted, table.select(residuals.rows))));
  list.add("normalized", value_of(residuals.normalized));
  return list.list();
}

SEXP predict_fit(SEXP handle, SEXP columns, SEXP settings) {
  const fit::FittedModel& fit = fit_of(handle);
  const data::Table table = table_of(cpp11::list(columns));
  const Arguments arguments(settings);
  const auto words = settings_of<study::PredictionSettings>(arguments);
  fit::PredictionOptions options = study::prediction_options(words);
  arguments.read("threads", options.threads);
  const auto prediction = in_background([&](Reports& /*reports*/) {
                            return fit::predict(fit, table, study::level_of(words.level), options);
                          }).first;
  return list_of(prediction);
}

SEXP intervals_of_fit(SEXP handle, SEXP columns, SEXP settings) {
  const fit::FittedModel& fit = fit_of(handle);
  const data::Table table = table_of(cpp11::list(columns));
  const Arguments arguments(settings);
  auto options = settings_of<fit::IntervalOptions>(arguments);
  arguments.read("threads", options.threads);
  const auto intervals = in_background([&](Reports& reports) {
                           options.stop = reports.stop();
                           return fit::confidence_intervals(fit, table, options);
                         }).first;
  return list_of(intervals);
}

SEXP compare_fits(SEXP handles) {
  std::vector<const fit::FittedModel*> fits;
  for (SEXP handle : cpp11::list(handles)) fits.push_back(&fit_of(handle));
  return list_of(fit::compare(fits), fits);
}

SEXP simulate_fit(SEXP handle, SEXP columns, SEXP replicates, SEXP seed) {
  const fit::FittedModel& fit = fit_of(handle);
  const data::Table table = table_of(cpp11::list(columns));
  const auto count = static_cast<std::size_t>(number_of(replicates));
  const auto seed_number = static_cast<std::uint64_t>(number_of(seed));
  const auto drawn = in_background([&](Reports& /*reports*/) {
                       return fit::simulate_responses(fit, table, count, seed_number);
                     }).first;
  NamedList list;
  list.add("rows", row_numbers(drawn.rows));
  list.add("values", value_of(drawn.values));
  return list.list();
}

}  // namespace silvafit::r
