// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
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

std::vector<std::string> counted_cells(std::string name,
                                       std::size_t count,
                                       const FitStatistics& values) {
  std::vector<std::string> cells = statistics_cells(std::move(name), values);
  cells.insert(cells.begin() + 1, fmt::to_string(count));
  return cells;
}

}  // namespace

std::string summary(const Bootstrap& bootstrap) {
  std::string text;
  append(text,
         "\n{} bootstrap, seed {}: {} of {} replicates converged; {:g} % intervals\n",
         word_of(bootstrap.resample),
         bootstrap.seed,
         bootstrap.converged,
         bootstrap.replicates,
         100.0 * bootstrap.level);
  TextTable table(9, {12, 12, 12, 25, 25});
  table.add({"parameter", "estimate", "bias", "std. error", "percentile", "basic"});
  for (const BootstrapParameter& parameter : bootstrap.parameters) {
    const auto range = [](const Interval& value) {
      if (std::isnan(value.low)) return std::string("-");
      return fmt::format("{} to {}", significant(value.low), significant(value.high));
    };
    table.add({parameter.name,
               significant(parameter.estimate),
               significant(parameter.bias, 3),
               significant(parameter.standard_error),
               range(parameter.percentile),
               range(parameter.basic)});
  }
  table.append_to(text);
  for (const BootstrapParameter& parameter : bootstrap.parameters) {
    if (parameter.replicates == bootstrap.converged) continue;
    append(text, "{}: of {} replicates only\n", parameter.name, parameter.replicates);
  }
  const std::size_t fewest = fewest_replicates(bootstrap.level);
  if (bootstrap.converged < fewest) {
    append(text,
           "Intervals of {:g} % need at least {} replicates.\n",
           100.0 * bootstrap.level,
           fewest);
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
  TextTable table(34, {8, 10, 10, 12, 10});
  table.add({"prediction of groups left out", "rows", "R2", "RMSE", "mean error", "MAE"});
  table.add(counted_cells("population", result.predicted_count, result.statistics));
  if (result.measured > 0) {
    table.add(counted_cells(fmt::format("calibrated with {} measured", result.measured),
                            result.calibrated_count,
                            result.calibrated_statistics));
    table.add(counted_cells(
        "population, the same rows", result.calibrated_count, result.uncalibrated_statistics));
  }
  table.append_to(text);
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
