// SPDX-License-Identifier: MIT
#include "prediction_options.hpp"

namespace silvafit::cli {
namespace {

/// The level of the predictions and the treatment of groups.
void add_level_options(CLI::App& command, study::PredictionSettings& settings) {
  command
      .add_option("--level",
                  settings.level,
                  "population: random effects 0 (b = 0); conditional: random effects of the fit; "
                  "calibrated: random effects from the trees measured in the file; marginal: mean "
                  "over all groups")
      ->check(CLI::IsMember({"population", "conditional", "calibrated", "marginal"}))
      ->capture_default_str();
  command
      .add_option("--new-groups",
                  settings.new_groups,
                  "Conditional predictions for groups that are not in the fit, and calibrated "
                  "predictions for such groups without a measured tree")
      ->check(CLI::IsMember({"population", "marginal", "missing", "error"}))
      ->capture_default_str();
  command
      .add_option("--seen-groups",
                  settings.seen_groups,
                  "Calibrated predictions for groups of the fit: use the random effects of the fit "
                  "(own), only the trees of the file (new), or both (combined)")
      ->check(CLI::IsMember({"fitted", "new", "combined"}))
      ->capture_default_str();
}

void add_interval_options(CLI::App& command, study::PredictionSettings& settings) {
  command
      .add_option(
          "--interval", settings.interval, "Add interval limits with this coverage, such as 0.95")
      ->type_name("LEVEL")
      ->check(CLI::Range(1e-6, 0.999999));
  command
      .add_option("--interval-kind",
                  settings.interval_kind,
                  "prediction: for the value of a tree; confidence: for the mean of such trees")
      ->check(CLI::IsMember({"prediction", "confidence"}))
      ->capture_default_str();
  command.add_flag("--standard-errors",
                   settings.standard_errors,
                   "Add the standard error of the kind that --interval-kind selects");
}

}  // namespace

void add_prediction_options(CLI::App& command, study::PredictionSettings& settings) {
  add_level_options(command, settings);
  add_interval_options(command, settings);
  command
      .add_option(
          "--role",
          settings.role,
          "Which models of a study to use; without this option, a model whose columns are not "
          "all in the file is replaced by the next simpler one")
      ->check(CLI::IsMember({"ols", "covariates", "nlme"}))
      ->default_str("nlme");
}

void refuse_idle_prediction_options(const CLI::App& command,
                                    const study::PredictionSettings& settings) {
  const bool is_calibrated = settings.level == "calibrated";
  refuse_idle(command,
              "--interval-kind",
              settings.interval > 0.0 || settings.standard_errors,
              "--interval or --standard-errors");
  refuse_idle(command,
              "--new-groups",
              is_calibrated || settings.level == "conditional",
              "--level conditional or calibrated");
  refuse_idle(command, "--seen-groups", is_calibrated, "--level calibrated");
}

}  // namespace silvafit::cli
