// SPDX-License-Identifier: MIT
#include "workflow/report_stand.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/table_checks.hpp"
#include "silvafit/study/tree_equations.hpp"

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
  const bool has_areas = record.sample.has_value() || inventory.has_coordinates();
  if (!has_areas || !record.study.options.period.empty()) return;
  add_volumes(catalogue, record);
  stand::Inventory trees = inventory;
  trees.represented.clear();
  stand::StandReportOptions options;
  options.units = units;
  options.design = design;
  options.by = {"species"};
  options.without_units = true;
  options.trust_units = true;  // the study has checked them
  try {
    record.stand = stand::stand_report(trees, options);
  } catch (const InputError&) {
    // Such as plots of one or two trees without a window, which have no area. A study has results
    // nevertheless.
    record.volume.clear();
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

}  // namespace silvafit::study
