// SPDX-License-Identifier: MIT
#include "fit_resampling.hpp"

#include <functional>
#include <nlohmann/json.hpp>

#include "help.hpp"
#include "setting_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/fit/inference_json.hpp"
#include "silvafit/fit/residuals.hpp"
#include "silvafit/fit/setting_list.hpp"
#include "silvafit/fit/summary.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

bool draws_groups(const fit::BootstrapOptions& bootstrap) {
  return bootstrap.replicates > 0 && bootstrap.resample == fit::Resample::kCases;
}

/// The progress of a part of the work.
std::function<void(std::size_t, std::size_t)> shown(Progress& progress, const char* name) {
  return
      [&progress, name](std::size_t done, std::size_t total) { progress.show(name, done, total); };
}

Resampling resample_one(const fit::FittedModel& fit,
                        const fit::FitModelOptions& refit,
                        const data::Table& table,
                        const ResamplingArguments& arguments,
                        const CommonOptions& common,
                        Progress& progress) {
  Resampling result;
  if (!fit.convergence.converged()) return result;
  const auto complete = [&](auto& options, const char* name) {
    options.seed = common.seed;
    options.threads = common.threads;
    options.refit = refit;
    options.progress = shown(progress, name);
  };
  if (arguments.bootstrap.replicates > 0) {
    fit::BootstrapOptions options = arguments.bootstrap;
    if (!draws_groups(options)) options.group.clear();
    complete(options, "bootstrap");
    result.bootstrap = fit::bootstrap(fit, table, options);
  }
  if (arguments.cross_validates) {
    fit::CrossValidationOptions options = arguments.cross_validation;
    options.group = arguments.bootstrap.group;
    complete(options, "cross-validation");
    result.cross_validation = fit::cross_validate(fit, table, options);
  }
  return result;
}

/// A row for each row of the table; rows with missing values have no residual.
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
  const std::string section = "Bootstrap and cross-validation";
  each_setting(arguments.bootstrap, SettingOptions(command, section));
  each_setting(arguments.cross_validation, SettingOptions(command, section, {"folds", "measured"}));
  command
      .add_option("--residuals",
                  arguments.residuals,
                  "File for fitted values and residuals: CSV, or a workbook (.xlsx, .ods)")
      ->type_name("FILE")
      ->group(kOutputSection);
}

std::vector<Resampling> resample(const std::vector<fit::FittedModel>& fits,
                                 const std::vector<fit::FitModelOptions>& options,
                                 const data::Table& table,
                                 const ResamplingArguments& arguments,
                                 const CommonOptions& common) {
  if (!arguments.residuals.empty() && fits.size() != 1) {
    throw UsageError("residuals can be written for one model only", {.column = "--residuals"});
  }
  const bool has_groups = draws_groups(arguments.bootstrap) || arguments.cross_validates;
  if (!arguments.bootstrap.group.empty() && !has_groups) {
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
  if (resampling.bootstrap) json["bootstrap"] = fit::json_of(*resampling.bootstrap);
  if (resampling.cross_validation) {
    json["cross_validation"] = fit::json_of(*resampling.cross_validation);
  }
  return json_text(json, 2);
}

void print_resampling(const std::vector<fit::FittedModel>& fits,
                      const std::vector<Resampling>& resampling) {
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const std::string model = fits.size() > 1 ? fits[i].model : "";
    if (resampling[i].bootstrap) {
      if (!model.empty()) print_text("\n{}", model);
      print_text("{}", with_options(fit::summary(*resampling[i].bootstrap)));
    }
    if (resampling[i].cross_validation) {
      print_text("{}", with_options(fit::summary(*resampling[i].cross_validation, model)));
    }
  }
}

}  // namespace silvafit::cli
