// SPDX-License-Identifier: MIT
// The bootstrap and cross-validation.
#include <cpp11/list.hpp>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "background.hpp"
#include "conversion.hpp"
#include "entry_points.hpp"
#include "fit_handle.hpp"
#include "settings.hpp"
#include "silvafit/fit/setting_list.hpp"

namespace silvafit::r {
namespace {

cpp11::sexp list_of(const fit::FitStatistics& statistics) {
  return value_of(nlohmann::ordered_json{{"r2", statistics.r2},
                                         {"mean_error", statistics.mean_error},
                                         {"rmse", statistics.rmse},
                                         {"mae", statistics.mae}});
}

/// Reasons with their numbers of replicates.
cpp11::sexp list_of(const std::vector<fit::CountedReason>& reasons) {
  std::vector<std::string> texts;
  std::vector<double> counts;
  for (const fit::CountedReason& one : reasons) {
    texts.push_back(one.reason);
    counts.push_back(static_cast<double>(one.replicates));
  }
  NamedList list;
  list.add("reason", value_of(texts));
  list.add("replicates", value_of(counts));
  return list.list();
}

cpp11::sexp list_of(const std::vector<fit::BootstrapParameter>& parameters) {
  std::vector<std::string> names;
  for (const fit::BootstrapParameter& one : parameters) names.push_back(one.name);
  NamedList list;
  list.add("name", value_of(names));
  const auto add = [&](const char* name, auto value) {
    std::vector<double> column;
    for (const fit::BootstrapParameter& one : parameters) column.push_back(value(one));
    list.add(name, value_of(column));
  };
  using Parameter = fit::BootstrapParameter;
  add("estimate", [](const Parameter& one) { return one.estimate; });
  add("replicates", [](const Parameter& one) { return static_cast<double>(one.replicates); });
  add("bias", [](const Parameter& one) { return one.bias; });
  add("se", [](const Parameter& one) { return one.standard_error; });
  add("percentile_lower", [](const Parameter& one) { return one.percentile.low; });
  add("percentile_upper", [](const Parameter& one) { return one.percentile.high; });
  add("basic_lower", [](const Parameter& one) { return one.basic.low; });
  add("basic_upper", [](const Parameter& one) { return one.basic.high; });
  return list.list();
}

std::function<void(std::size_t, std::size_t)> progress_of(const char* name, Reports& reports) {
  return [name, progress = reports.callbacks().progress](std::size_t done, std::size_t total) {
    progress(name, done, total);
  };
}

}  // namespace

SEXP bootstrap_fit(SEXP handle, SEXP columns, SEXP settings) {
  const fit::FittedModel& fit = fit_of(handle);
  const data::Table table = table_of(cpp11::list(columns));
  const Arguments arguments(settings);
  auto options = settings_of<fit::BootstrapOptions>(arguments);
  options.refit = fit_options(Arguments(arguments["refit"]));
  arguments.read("seed", options.seed);
  arguments.read("threads", options.threads);
  const auto found = in_background(
                         [&](Reports& reports) {
                           options.refit.stop = reports.stop();
                           options.progress = progress_of("bootstrap", reports);
                           return fit::bootstrap(fit, table, options);
                         },
                         shows_progress(arguments))
                         .first;
  NamedList list;
  list.add("replicates", value_of(std::vector{static_cast<double>(found.replicates)}));
  list.add("converged", value_of(std::vector{static_cast<double>(found.converged)}));
  list.add("parameters", list_of(found.parameters));
  list.add("values", value_of(Eigen::MatrixXd(found.values.transpose())));
  list.add("failures", list_of(found.failures));
  list.add("boundary", list_of(found.at_boundary));
  return list.list();
}

SEXP cross_validate_fit(SEXP handle, SEXP columns, SEXP settings) {
  const fit::FittedModel& fit = fit_of(handle);
  const data::Table table = table_of(cpp11::list(columns));
  const Arguments arguments(settings);
  auto options = settings_of<fit::CrossValidationOptions>(arguments);
  options.refit = fit_options(Arguments(arguments["refit"]));
  arguments.read("seed", options.seed);
  arguments.read("threads", options.threads);
  const auto found = in_background(
                         [&](Reports& reports) {
                           options.refit.stop = reports.stop();
                           options.progress = progress_of("cross-validation", reports);
                           return fit::cross_validate(fit, table, options);
                         },
                         shows_progress(arguments))
                         .first;
  nlohmann::ordered_json failed = nlohmann::ordered_json::array();
  for (const fit::FailedFold& fold : found.failed) {
    failed.push_back({{"groups", fold.groups}, {"message", fold.verdict}});
  }
  NamedList list;
  list.add("rows", row_numbers(found.rows));
  list.add("fold", row_numbers(found.fold));
  list.add("observed", value_of(found.observed));
  list.add("predicted", value_of(found.predicted));
  list.add("calibrated", value_of(found.calibrated));
  list.add("population", list_of(found.statistics));
  list.add("calibrated_statistics", list_of(found.calibrated_statistics));
  list.add("mean_log_density", value_of(std::vector{found.log_density}));
  list.add("failed", value_of(failed));
  return list.list();
}

}  // namespace silvafit::r
