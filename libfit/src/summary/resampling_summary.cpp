// SPDX-License-Identifier: MIT
#include <algorithm>
#include <string>
#include <vector>

#include "silvafit/base/text.hpp"
#include "silvafit/fit/summary.hpp"
#include "summary/text_lines.hpp"

namespace silvafit::fit {
namespace {

void append_reasons(std::string& text,
                    const char* what,
                    const std::vector<CountedReason>& reasons) {
  for (const CountedReason& one : reasons) {
    append(
        text, "{} {}: {}\n", counted(one.replicates, "replicate", "replicates"), what, one.reason);
  }
}

void append_statistics_line(std::string& text,
                            const std::string& name,
                            const FitStatistics& values,
                            std::size_t count) {
  append(text,
         "{:<34} {:>8} {:>10} {:>10} {:>12} {:>10}\n",
         name,
         count,
         decimals(values.r2),
         significant(values.rmse),
         significant(values.mean_error, 3),
         significant(values.mae));
}

}  // namespace

std::string summary(const Bootstrap& bootstrap) {
  std::string text;
  std::size_t width = 9;
  for (const auto& parameter : bootstrap.parameters) width = std::max(width, parameter.name.size());
  append(text,
         "\n{} bootstrap, seed {}: {} of {} replicates converged; {:g} % intervals\n",
         resample_text(bootstrap.resample),
         bootstrap.seed,
         bootstrap.converged,
         bootstrap.replicates,
         100.0 * bootstrap.level);
  append(text,
         "{:<{}} {:>12} {:>12} {:>12} {:>25} {:>25}\n",
         "parameter",
         width,
         "estimate",
         "bias",
         "std. error",
         "percentile",
         "basic");
  for (const BootstrapParameter& parameter : bootstrap.parameters) {
    const auto range = [](const Interval& value) {
      return fmt::format("{} to {}", significant(value.low), significant(value.high));
    };
    append(text,
           "{:<{}} {:>12} {:>12} {:>12} {:>25} {:>25}\n",
           parameter.name,
           width,
           significant(parameter.estimate),
           significant(parameter.bias, 3),
           significant(parameter.standard_error),
           range(parameter.percentile),
           range(parameter.basic));
  }
  append_reasons(text, "at a boundary", bootstrap.at_boundary);
  append_reasons(text, "failed", bootstrap.failures);
  return text;
}

std::string summary(const CrossValidation& result, const std::string& model) {
  std::string text;
  append(text,
         "\n{}{}cross-validation, {} folds of {}, seed {}\n",
         model,
         model.empty() ? "" : ": ",
         result.folds,
         counted(result.groups, result.group + " group", result.group + " groups"),
         result.seed);
  append(text,
         "{:<34} {:>8} {:>10} {:>10} {:>12} {:>10}\n",
         "prediction of groups left out",
         "rows",
         "R2",
         "RMSE",
         "mean error",
         "MAE");
  append_statistics_line(text, "population", result.statistics, result.predicted_count);
  if (result.measured > 0) {
    append_statistics_line(text,
                           fmt::format("calibrated with {} measured", result.measured),
                           result.calibrated_statistics,
                           result.calibrated_count);
    append_statistics_line(
        text, "population, the same rows", result.uncalibrated_statistics, result.calibrated_count);
  }
  append(text, "mean log predictive density {}\n", significant(result.log_density));
  if (result.density_count < result.predicted_count) {
    append(text,
           "of {} of these rows; the variance of the others was not known without their fold\n",
           result.density_count);
  }
  for (const FailedFold& fold : result.failed) {
    append(text,
           "a fold failed ({} {}): {}\n",
           result.group,
           fmt::join(fold.groups, ", "),
           fold.verdict);
  }
  return text;
}

}  // namespace silvafit::fit
