// SPDX-License-Identifier: MIT
#include "fit_resampling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "number_text.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/residuals.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

constexpr const char* kLeaveOneOut = "leave-one-out";

/// Folds of `--cross-validate`; 0 for one group at a time.
std::size_t folds_of(const std::string& text) {
  if (text == kLeaveOneOut) return 0;
  double value = 0.0;
  if (data::parse_number(text, value) && value >= 2.0 && value <= 0x1p53 &&
      value == std::floor(value)) {
    return static_cast<std::size_t>(value);
  }
  throw UsageError(
      fmt::format("'{}' is neither a number of folds (at least 2) nor {}", text, kLeaveOneOut),
      {.column = "--cross-validate"});
}

bool draws_groups(const ResamplingArguments& arguments) {
  return arguments.bootstrap > 0 &&
         fit::parse_resample(arguments.resample) == fit::Resample::kCases;
}

Resampling resample_one(const fit::FittedModel& fit,
                        const fit::FitModelOptions& options,
                        const data::Table& table,
                        const ResamplingArguments& arguments,
                        const CommonOptions& common,
                        Progress& progress) {
  Resampling result;
  if (!fit.convergence.converged()) return result;
  if (arguments.bootstrap > 0) {
    result.bootstrap = fit::bootstrap(fit,
                                      table,
                                      {.replicates = arguments.bootstrap,
                                       .resample = fit::parse_resample(arguments.resample),
                                       .level = arguments.level,
                                       .seed = common.seed,
                                       .threads = common.threads,
                                       .group = draws_groups(arguments) ? arguments.group : "",
                                       .refit = options,
                                       .progress = [&](std::size_t done, std::size_t total) {
                                         progress.show("bootstrap", done, total);
                                       }});
  }
  if (!arguments.cross_validate.empty()) {
    result.cross_validation =
        fit::cross_validate(fit,
                            table,
                            {.folds = folds_of(arguments.cross_validate),
                             .group = arguments.group,
                             .measured = arguments.measured,
                             .seed = common.seed,
                             .threads = common.threads,
                             .refit = options,
                             .progress = [&](std::size_t done, std::size_t total) {
                               progress.show("cross-validation", done, total);
                             }});
  }
  return result;
}

ordered_json interval(const fit::Interval& value) {
  return {number_or_null(value.low), number_or_null(value.high)};
}

ordered_json reasons(const std::vector<fit::CountedReason>& counted) {
  ordered_json result = ordered_json::array();
  for (const fit::CountedReason& one : counted) {
    result.push_back({{"reason", one.reason}, {"replicates", one.replicates}});
  }
  return result;
}

ordered_json bootstrap_json(const fit::Bootstrap& bootstrap) {
  ordered_json parameters = ordered_json::object();
  for (const fit::BootstrapParameter& parameter : bootstrap.parameters) {
    parameters[parameter.name] = {{"estimate", number_or_null(parameter.estimate)},
                                  {"replicates", parameter.replicates},
                                  {"bias", number_or_null(parameter.bias)},
                                  {"se", number_or_null(parameter.standard_error)},
                                  {"percentile", interval(parameter.percentile)},
                                  {"basic", interval(parameter.basic)}};
  }
  return {{"resample", fit::resample_text(bootstrap.resample)},
          {"seed", bootstrap.seed},
          {"level", bootstrap.level},
          {"replicates", bootstrap.replicates},
          {"converged", bootstrap.converged},
          {"parameters", std::move(parameters)},
          {"failures", reasons(bootstrap.failures)},
          {"on_edge", reasons(bootstrap.on_edge)}};
}

ordered_json statistics_json(const fit::FitStatistics& values) {
  return {{"r2", number_or_null(values.r2)},
          {"mean_error", number_or_null(values.mean_error)},
          {"rmse", number_or_null(values.rmse)},
          {"mae", number_or_null(values.mae)}};
}

ordered_json cross_validation_json(const fit::CrossValidation& result) {
  ordered_json failed = ordered_json::array();
  for (const fit::FailedFold& fold : result.failed) {
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

void print_reasons(const char* what, const std::vector<fit::CountedReason>& reasons) {
  for (const fit::CountedReason& one : reasons) {
    print_text("{} {}: {}\n", counted(one.replicates, "replicate", "replicates"), what, one.reason);
  }
}

void print_bootstrap(const fit::Bootstrap& bootstrap) {
  std::size_t width = 9;
  for (const auto& parameter : bootstrap.parameters) width = std::max(width, parameter.name.size());
  print_text("\n{} bootstrap, seed {}: {} of {} replicates converged; {:g} % intervals\n",
             fit::resample_text(bootstrap.resample),
             bootstrap.seed,
             bootstrap.converged,
             bootstrap.replicates,
             100.0 * bootstrap.level);
  print_text("{:<{}} {:>12} {:>12} {:>12} {:>25} {:>25}\n",
             "parameter",
             width,
             "estimate",
             "bias",
             "std. error",
             "percentile",
             "basic");
  for (const fit::BootstrapParameter& parameter : bootstrap.parameters) {
    const auto range = [](const fit::Interval& value) {
      return fmt::format("{} to {}", significant(value.low), significant(value.high));
    };
    print_text("{:<{}} {:>12} {:>12} {:>12} {:>25} {:>25}\n",
               parameter.name,
               width,
               significant(parameter.estimate),
               significant(parameter.bias, 3),
               significant(parameter.standard_error),
               range(parameter.percentile),
               range(parameter.basic));
  }
  print_reasons("at a boundary", bootstrap.on_edge);
  print_reasons("failed", bootstrap.failures);
}

void print_statistics_line(const std::string& name,
                           const fit::FitStatistics& values,
                           std::size_t count) {
  print_text("{:<34} {:>8} {:>10} {:>10} {:>12} {:>10}\n",
             name,
             count,
             decimals(values.r2),
             significant(values.rmse),
             significant(values.mean_error, 3),
             significant(values.mae));
}

void print_cross_validation(const fit::CrossValidation& result, const std::string& model) {
  print_text("\n{}{}cross-validation, {} folds of {}, seed {}\n",
             model,
             model.empty() ? "" : ": ",
             result.folds,
             counted(result.groups, result.group + " group", result.group + " groups"),
             result.seed);
  print_text("{:<34} {:>8} {:>10} {:>10} {:>12} {:>10}\n",
             "prediction of groups left out",
             "rows",
             "R2",
             "RMSE",
             "mean error",
             "MAE");
  print_statistics_line("population", result.statistics, result.predicted_count);
  if (result.measured > 0) {
    print_statistics_line(fmt::format("calibrated with {} measured", result.measured),
                          result.calibrated_statistics,
                          result.calibrated_count);
    print_statistics_line(
        "population, the same rows", result.uncalibrated_statistics, result.calibrated_count);
  }
  print_text("mean log predictive density {}\n", significant(result.log_density));
  if (result.density_count < result.predicted_count) {
    print_text("of {} of these rows; the variance of the others was not known without their fold\n",
               result.density_count);
  }
  for (const fit::FailedFold& fold : result.failed) {
    print_text(
        "a fold failed ({} {}): {}\n", result.group, fmt::join(fold.groups, ", "), fold.verdict);
  }
}

/// A row for each row of the table; one with missing values has no residual.
data::Table residuals_table(const fit::Residuals& all, const data::Table& table) {
  std::vector<double> lines;
  data::TextColumn group;
  std::vector<std::size_t> place_of_row(table.rows(), all.rows.size());
  for (std::size_t i = 0; i < all.rows.size(); ++i) place_of_row[all.rows[i]] = i;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    lines.push_back(static_cast<double>(table.line(row) > 0 ? table.line(row) : row + 1));
    const std::size_t place = place_of_row[row];
    place < all.rows.size() ? group.append(all.group[place]) : group.append_missing();
  }
  data::Table result(table.rows());
  result.set("line", std::move(lines));
  result.set("group", std::move(group));
  const auto add = [&](const char* name, const Eigen::VectorXd& values) {
    std::vector<double> column;
    for (const std::size_t place : place_of_row) {
      const bool is_used = place < all.rows.size();
      column.push_back(is_used ? values[static_cast<Eigen::Index>(place)] : data::kMissing);
    }
    result.set(name, std::move(column));
  };
  add("observed", all.observed);
  add("fitted_population", all.population.fitted);
  add("fitted_conditional", all.conditional.fitted);
  add("residual_population", all.population.raw);
  add("residual_conditional", all.conditional.raw);
  add("standardized_population", all.population.standardized);
  add("standardized_conditional", all.conditional.standardized);
  add("normalized", all.normalized);
  add("marginal", all.marginal);
  return result;
}

}  // namespace

void add_resampling_options(CLI::App& command, ResamplingArguments& arguments) {
  command
      .add_option("--bootstrap",
                  arguments.bootstrap,
                  "Bootstrap: number of refits for standard errors and intervals of all parameters")
      ->type_name("REPLICATES")
      ->check(CLI::Range(2, 10000000));
  command
      .add_option("--resample",
                  arguments.resample,
                  "Bootstrap data: parametric (simulated from the fit) or cases (groups drawn with "
                  "replacement)")
      ->check(CLI::IsMember({"parametric", "cases"}))
      ->capture_default_str();
  command.add_option("--bootstrap-level", arguments.level, "Level of the bootstrap intervals")
      ->capture_default_str();
  command
      .add_option("--cross-validate",
                  arguments.cross_validate,
                  "Cross-validation over groups: a number of folds, or leave-one-out")
      ->type_name("FOLDS");
  command.add_option(
      "--measured-trees",
      arguments.measured,
      "Number of trees per left-out group that are used as measured, to calibrate the others");
  command.add_option("--group",
                     arguments.group,
                     "Column of the groups to draw or leave out (default: the groups of the random "
                     "effects, the outer ones if nested)");
  command
      .add_option("--residuals",
                  arguments.residuals,
                  "File for fitted values and residuals: CSV, or a workbook (.xlsx, .ods)")
      ->type_name("FILE");
}

std::vector<Resampling> resample(const std::vector<fit::FittedModel>& fits,
                                 const std::vector<fit::FitModelOptions>& options,
                                 const data::Table& table,
                                 const ResamplingArguments& arguments,
                                 const CommonOptions& common) {
  if (!arguments.residuals.empty() && fits.size() != 1) {
    throw UsageError("residuals can be written for one model only", {.column = "--residuals"});
  }
  if (!arguments.group.empty() && !draws_groups(arguments) && arguments.cross_validate.empty()) {
    throw UsageError("--group needs --resample cases or --cross-validate", {.column = "--group"});
  }
  std::vector<Resampling> result;
  Progress progress(common);
  for (std::size_t i = 0; i < fits.size(); ++i) {
    result.push_back(resample_one(fits[i], options[i], table, arguments, common, progress));
  }
  return result;
}

void write_residuals(const std::vector<fit::FittedModel>& fits,
                     const data::Table& table,
                     const ResamplingArguments& arguments) {
  if (arguments.residuals.empty() || !fits.front().convergence.converged()) return;
  write_table(arguments.residuals,
              "residuals",
              residuals_table(fit::residuals(fits.front(), table), table));
}

std::string with_resampling(const std::string& fit_json,
                            const Resampling& resampling,
                            const std::vector<std::string>& recognized) {
  const bool has_resampling = resampling.bootstrap || resampling.cross_validation;
  if (!has_resampling && recognized.empty()) return fit_json;
  ordered_json json = ordered_json::parse(fit_json);
  if (!recognized.empty()) json["recognized"] = recognized;
  if (resampling.bootstrap) json["bootstrap"] = bootstrap_json(*resampling.bootstrap);
  if (resampling.cross_validation) {
    json["cross_validation"] = cross_validation_json(*resampling.cross_validation);
  }
  return json_text(json, 2);
}

void print_resampling(const std::vector<fit::FittedModel>& fits,
                      const std::vector<Resampling>& resampling) {
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const std::string model = fits.size() > 1 ? fits[i].model : "";
    if (resampling[i].bootstrap) {
      if (!model.empty()) print_text("\n{}", model);
      print_bootstrap(*resampling[i].bootstrap);
    }
    if (resampling[i].cross_validation) {
      print_cross_validation(*resampling[i].cross_validation, model);
    }
  }
}

}  // namespace silvafit::cli
