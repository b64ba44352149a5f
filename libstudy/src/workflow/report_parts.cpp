// SPDX-License-Identifier: MIT
#include "workflow/report_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/table_checks.hpp"
#include "silvafit/study/tree_equations.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {
namespace {

/// Naslund's curve has two coefficients; with fewer trees a curve says little.
constexpr std::size_t kEnoughHeights = 20;
constexpr char kHeightModel[] = "M1";

/// Measured heights, and the best predictions of the others.
std::vector<double> complete_heights(const StudyRecord& record) {
  const data::Table table = predictions_of(record, library_of(record));
  std::vector<double> heights(table.rows(), data::kMissing);
  for (const char* name : {"h", "h_conditional", "h_population", "h_ols"}) {
    if (!table.has(name)) continue;
    const auto values = table.numbers(name);
    for (std::size_t row = 0; row < heights.size(); ++row) {
      if (std::isnan(heights[row])) heights[row] = values[row];
    }
  }
  return heights;
}

void add_volumes(const Catalogue& catalogue, StudyRecord& record) {
  stand::Inventory& inventory = record.inventory.inventory;
  if (inventory.h_m.empty()) return;
  data::Table trees = stand::to_table(inventory);
  trees.set("h", complete_heights(record));
  // Base models are in the folder `base` of the models.
  const auto folder = catalogue.models().front().file.parent_path().parent_path();
  inventory.quantities =
      tree_quantities(trees, {.equations = {"taper"}, .models = folder}).quantities;
  record.volume =
      "of the stem over bark, by the taper equations with which trees are drawn; heights that were "
      "not measured are predicted";
}

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
    const auto has_several = [](const ResponseStudy& result) { return result.plots > 1; };
    decisions.emplace_back(
        "Level 3",
        record.study.results.empty() || std::ranges::any_of(record.study.results, has_several)
            ? "skipped: no model reached this level"
            : fmt::format("skipped: random effects of {} need several of them", options.group));
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

void add_stand(const stand::StructuralUnitOptions& units,
               const stand::SamplingDesign& design,
               const Catalogue& catalogue,
               StudyRecord& record) {
  for (const ResponseStudy& result : record.study.results) {
    if (result.response != "h" || !result.ols) continue;
    record.height_curves.push_back({.species = result.species, .fit = result.ols->fit});
  }
  const stand::Inventory& inventory = record.inventory.inventory;
  if (!record.study.options.period.empty()) return;
  const bool has_areas = record.sample.has_value() || inventory.has_coordinates();
  if (has_areas) add_volumes(catalogue, record);
  stand::Inventory trees = inventory;
  trees.represented.clear();
  stand::StandReportOptions options;
  options.units = units;
  options.design = design;
  options.by = {"species"};
  options.without_units = true;
  options.trust_units = true;  // the study has checked them
  // Plots of one or two trees without a window have no area, either.
  for (const bool without_areas : {!has_areas, true}) {
    options.without_areas = without_areas;
    try {
      record.stand = stand::stand_report(trees, options);
      break;
    } catch (const InputError&) {
      // A study has results nevertheless.
      record.volume.clear();
    }
  }
}

std::vector<HeightCurve> height_curves_of(const stand::Inventory& inventory,
                                          const Catalogue& catalogue) {
  std::vector<HeightCurve> curves;
  if (inventory.h_m.empty()) return curves;
  std::map<std::string, std::vector<std::size_t>> trees_of;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    const bool is_measured = !std::isnan(inventory.h_m[row]) && !inventory.is_neighbor_only(row);
    if (is_measured) trees_of[std::string(inventory.species[row])].push_back(row);
  }
  const data::Table table = stand::to_table(inventory);
  for (const auto& [species, rows] : trees_of) {
    if (rows.size() < kEnoughHeights) continue;
    const data::Table trees = table.select(rows);
    fit::ModelTexts texts;
    fit::FitModelOptions options;
    use_base_model(catalogue.find(kHeightModel), trees, texts, options);
    fit::FittedModel fit = fit::fit_model(fit::specify_model(texts, trees), trees, options).fit;
    fit.model = kHeightModel;
    if (!fit.convergence.converged()) continue;
    curves.push_back({.species = species, .fit = std::move(fit)});
  }
  return curves;
}

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
  } else if (!record.height_curves.empty()) {
    decisions.emplace_back(
        "Height curves",
        fmt::format("Naslund's curve ({}) by least squares, for species with at least {} measured "
                    "heights; trees outside of windows and circles are used, too",
                    kHeightModel,
                    kEnoughHeights));
  }
  return decisions;
}

}  // namespace silvafit::study
