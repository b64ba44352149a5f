// SPDX-License-Identifier: MIT
#include "workflow/study_decisions.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "silvafit/study/setting_list.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {
namespace {

/// The name of a criterion in a sentence.
std::string named(Criterion criterion) {
  switch (criterion) {
    case Criterion::kAic:
      return "AIC";
    case Criterion::kAicc:
      return "AICc";
    case Criterion::kBic:
      return "BIC";
    case Criterion::kCrossValidation:
      break;
  }
  return "prediction error for plots left out (10 folds)";
}

/// "2 AIC", or one standard error of an error.
std::string distance(Criterion criterion, double equally_good) {
  return criterion == Criterion::kCrossValidation
             ? "one standard error"
             : fmt::format("{:g} {}", equally_good, named(criterion));
}

void add_level_decisions(const StudyRecord& record, Decisions& decisions) {
  const StudyOptions& options = record.study.options;
  const LevelCriteria& criteria = options.criteria;
  const std::string test = options.needs_tests ? fmt::format(", likelihood-ratio test at {:g} %",
                                                             100.0 * options.significance)
                                               : std::string();
  const auto best = [&](Criterion criterion) {
    return options.parsimonious ? fmt::format("fewest parameters within {} of the best",
                                              distance(criterion, options.equally_good))
                                : fmt::format("lowest {}", named(criterion));
  };
  const auto got_to = [&](std::vector<Candidate> ResponseStudy::*level) {
    return std::ranges::any_of(record.study.results, [level](const ResponseStudy& result) {
      return !(result.*level).empty();
    });
  };
  decisions.emplace_back("Level 1",
                         got_to(&ResponseStudy::base)
                             ? fmt::format("fewest parameters within {} of the best base model",
                                           distance(criteria.base, options.equally_good))
                             : "skipped: no models were fitted");
  decisions.emplace_back(
      "Level 2",
      got_to(&ResponseStudy::covariates)
          ? fmt::format(
                "lowest {} of covariate subsets on {}{}",
                named(criteria.covariates),
                options.covariate_parameters > 1 ? "one or two parameters" : "one parameter",
                test)
          : "skipped: no model reached this level, or there are no covariates (structural units "
            "need positions)");
  if (!got_to(&ResponseStudy::random)) {
    decisions.emplace_back("Level 3", "skipped: no model reached this level");
    return;
  }
  decisions.emplace_back(
      "Level 3",
      fmt::format("Lindstrom-Bates, maximum likelihood; random effects of {}{} on up to {} "
                  "coefficients by {}, then variance function by {}{}",
                  options.group,
                  options.period.empty()
                      ? ""
                      : fmt::format(", and of {} within {},", options.period, options.group),
                  options.maximum_random_effects,
                  best(criteria.random),
                  best(criteria.variance),
                  test));
}

std::string window_text(const UnitSettings& units) {
  if (!units.window.empty()) return std::filesystem::path(units.window).filename().string();
  if (!units.windows.empty()) return "given windows";
  return fmt::format("convex hull of {}",
                     units.per == stand::SearchScope::kStand ? "the stand" : "each plot");
}

/// "circles 7=4, 30=12; table of plots plots.csv".
std::string design_text(const SamplingSettings& sampling) {
  std::vector<std::string> parts;
  if (!sampling.circles.empty()) {
    parts.push_back(fmt::format("circles {}", fmt::join(sampling.circles, ", ")));
  }
  if (sampling.angle_count > 0.0) {
    parts.push_back(fmt::format("angle count {:g} m2/ha", sampling.angle_count));
  }
  if (!sampling.expansion.empty()) parts.push_back("expansion factors " + sampling.expansion);
  if (sampling.subplots > 1) parts.push_back(fmt::format("{} subplots", sampling.subplots));
  if (!sampling.plots_file.empty()) {
    parts.push_back("table of plots " +
                    std::filesystem::path(sampling.plots_file).filename().string());
  } else if (sampling.plots) {
    parts.emplace_back("a table of plots");
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::string window_text(const StudyRecord& record) {
  if (record.sample) return "circle of the smallest counted dbh of each plot";
  return window_text(record.settings.units);
}

}  // namespace

Decisions decisions_of(const StudyRecord& record) {
  Decisions decisions;
  if (record.sample) {
    decisions.emplace_back("Sampling design", design_text(record.settings.sampling));
  }
  if (record.units) {
    const UnitSettings& units = record.settings.units;
    const auto words = settings_json(units);
    decisions.emplace_back("Window", window_text(record));
    decisions.emplace_back("Edge correction",
                           units.edge == stand::EdgeCorrection::kBuffer
                               ? fmt::format("buffer of {} m", units.buffer_m)
                               : words["edge"].get<std::string>());
    decisions.emplace_back("Structural units",
                           fmt::format("{} nearest neighbors, searched in the {}",
                                       units.neighbors,
                                       words["per"].get<std::string>()));
  }
  // Stand tables have no study.
  if (!record.study.stages.empty() || !record.study.results.empty()) {
    add_level_decisions(record, decisions);
  }
  return decisions;
}

}  // namespace silvafit::study
