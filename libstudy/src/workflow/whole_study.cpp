// SPDX-License-Identifier: MIT
#include "silvafit/study/whole_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "report/report_json.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/stand/plots_at_times.hpp"
#include "silvafit/stand/sampling_design.hpp"
#include "silvafit/study/column_uses.hpp"
#include "silvafit/study/indices.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/tree_table.hpp"
#include "study/study_work.hpp"
#include "workflow/report_parts.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

bool is_formula(const std::string& candidate) { return candidate.find('~') != std::string::npos; }

/// The formulas of the user, which may read any column.
std::vector<std::string> own_formulas(const StudyOptions& options) {
  std::vector<std::string> formulas;
  for (const auto& [response, candidates] : options.candidates) {
    std::ranges::copy_if(candidates, std::back_inserter(formulas), is_formula);
  }
  return formulas;
}

/// Columns of the file that a study reads besides those of an inventory: covariates, the group,
/// those of the sampling design and of variance functions.
std::vector<std::string> other_columns(const StudyConfiguration& settings) {
  const StudyOptions& options = settings.study;
  constexpr std::size_t kMostCovariates = 8;
  if (options.covariates.size() > kMostCovariates) {
    throw UsageError(fmt::format("{} covariates have too many subsets; the maximum is {}",
                                 options.covariates.size(),
                                 kMostCovariates),
                     {.column = "`covariates`"});
  }
  std::vector<std::string> names = options.covariates;
  const std::vector<std::string> of_variance = variance_columns(options);
  names.insert(names.end(), of_variance.begin(), of_variance.end());
  const auto mapped = column_map(settings.reading.columns);
  std::erase_if(names, [&mapped](const std::string& name) {
    return is_structure_name(name) && !mapped.contains(name);
  });
  const std::vector<std::string> of_design = columns_of(settings.sampling);
  names.insert(names.end(), of_design.begin(), of_design.end());
  if (options.group != "plot") names.push_back(options.group);
  const std::set<std::string> of_formulas =
      column_uses({.formulas = own_formulas(options)}).as_numbers;
  names.insert(names.end(), of_formulas.begin(), of_formulas.end());
  return names;
}

/// How plots and trees were sampled; not given without a design.
stand::SamplingDesign design_of(const StudyConfiguration& settings,
                                const stand::Inventory& inventory) {
  stand::SamplingDesign design = sampling_design(settings.sampling);
  const bool has_windows = !settings.units.window.empty() || !settings.units.circle.empty() ||
                           !settings.units.windows.empty();
  if (!has_windows) design = stand::design_for(inventory, std::move(design));
  if (design.is_given() && !settings.study.period.empty()) {
    design = stand::design_at_times(std::move(design), stand::plots_at_times(inventory));
  }
  return design;
}

/// The further indices that a study computes: those of its settings, and its covariates.
std::vector<stand::FurtherIndex> further_indices_of(const StudyConfiguration& settings) {
  std::vector<stand::FurtherIndex> indices = further_indices(settings.units);
  for (const std::string& name : settings.study.covariates) {
    if (const auto index = find_word<stand::FurtherIndex>(name)) indices.push_back(*index);
  }
  return indices;
}

stand::StructuralUnitOptions unit_options_of(const StudyConfiguration& settings,
                                             const stand::Inventory& inventory) {
  stand::StructuralUnitOptions options = unit_options(settings.units, settings.study.threads);
  options.further = further_indices_of(settings);
  if (!settings.study.period.empty()) {
    options.windows = stand::windows_at_times(options.windows, stand::plots_at_times(inventory));
  }
  return options;
}

/// Structural units of sampled plots, if some of their neighborhoods are complete.
void add_units_of_sample(const stand::StructuralUnitOptions& options, StudyRecord& record) {
  const stand::Inventory& inventory = record.inventory.inventory;
  stand::StructuralUnits units =
      stand::structural_units_of_sample(inventory, *record.sample, options);
  const bool has_core =
      std::ranges::any_of(units.core, [](const auto is_core) { return is_core != 0; });
  if (has_core) {
    record.units = std::move(units);
  } else {
    record.sample->notes.emplace_back(
        "no tree has a complete neighborhood within its sampled plot; structural units are "
        "skipped, and models use all trees");
  }
}

/// The structural units, if trees have positions, and a table with them.
void add_structure(const StudyConfiguration& settings,
                   const Callbacks& callbacks,
                   StudyRecord& record) {
  const stand::Inventory& inventory = record.inventory.inventory;
  const stand::StructuralUnitOptions options = unit_options_of(settings, inventory);
  const auto& covariates = settings.study.covariates;
  const bool has_positions = inventory.has_coordinates();
  const stand::SamplingDesign design = design_of(settings, inventory);
  if (design.is_given()) record.sample = stand::sample_of(inventory, design);
  if (record.sample) {
    if (has_positions) add_units_of_sample(options, record);
    give_notes(record.sample->notes, callbacks.note);
  } else if (has_positions) {
    record.units = stand::structural_units(inventory, options);
  }
  if (record.units) give_notes(record.units->notes, callbacks.note);
  record.table = inventory_table(inventory, record.units);
  if (record.sample) {
    record.inventory.inventory.represented = record.sample->represented;
    return add_plot_columns(covariates, inventory, record.sample->areas, record.table);
  }
  if (!has_positions) return;
  // Without crown widths there is no C, and computing the units again would not change that.
  const bool wants_crowding = std::ranges::find(covariates, "C") != covariates.end();
  if (wants_crowding && !record.table.has("C")) {
    record.table.set("C", std::vector<double>(record.table.rows(), data::kMissing));
  }
  give_notes(
      add_structure_columns(structure_names_in(covariates, record.table), record.table, options),
      callbacks.note);
}

/// In the table, plots and times are columns of their own.
void separate_periods(const std::string& period, StudyRecord& record) {
  if (period.empty()) return;
  record.table.set("plot", record.inventory.inventory.measured_plot);
  record.table.set(period, record.inventory.inventory.time);
}

/// \throws UsageError if times cannot be used as periods of the groups
void check_period(const StudyConfiguration& settings) {
  if (settings.study.period.empty()) return;
  if (settings.study.period == settings.study.group) {
    throw UsageError("the periods need another column than the groups of the random effects",
                     {.column = "`period`"});
  }
  if (settings.units.per == stand::SearchScope::kStand) {
    throw UsageError(
        "with periods, neighbors are searched within each plot and time; use `per=plot`",
        {.column = "`per`"});
  }
}

ordered_json left_out_json(const ResponseStudy& result) {
  ordered_json json = left_out_object(result);
  for (const char* key : {"folds", "trees", "r2_ols", "r2_covariates", "r2_nlme", "t"}) {
    if (result.left_out) json.erase(key);
  }
  return json;
}

ordered_json result_json(const ResponseStudy& result) {
  const std::string formula = result.ols ? result.ols->fit.specification.formula.text : "";
  return {{"species", result.species},
          {"response", result.response},
          {"n", result.rows.size()},
          {"model", text_or_null(result.ols ? result.ols->fit.model : "")},
          {"formula", text_or_null(formula)},
          {"covariates", result.chosen_terms(&ResponseStudy::covariates)},
          {"random", result.chosen_terms(&ResponseStudy::random)},
          {"variance", result.nlme ? result.nlme->fit.variance.function().text() : ""},
          {"r2_ols", number_or_null(result.ols ? result.ols->fit.population.r2 : NAN)},
          {"r2_nlme", number_or_null(result.nlme ? result.nlme->fit.conditional.r2 : NAN)},
          {"converged", result.converged()},
          {"verdict", result.verdict()},
          {"sound", result.is_sound()},
          {"doubts", result.doubts},
          {"notes", result.notes},
          {"rejected", result.rejected()},
          {"left_out", left_out_json(result)}};
}

}  // namespace

StudyRecord whole_study(const data::TableSource& inventory,
                        const Catalogue& catalogue,
                        const StudyConfiguration& settings,
                        const Callbacks& callbacks) {
  refuse_idle(settings);
  check_period(settings);
  StudyRecord record{.version = SILVAFIT_VERSION, .settings = settings};
  record.inventory = read_inventory(inventory,
                                    settings.reading,
                                    {.keep = other_columns(settings),
                                     .keep_all = !own_formulas(settings.study).empty(),
                                     .refuses_unread = true,
                                     .has_expansion = !settings.sampling.expansion.empty(),
                                     .keeps_expansion = true,
                                     .period = settings.study.period},
                                    callbacks.note);
  add_structure(settings, callbacks, record);
  separate_periods(settings.study.period, record);
  record.study = run_study(record.table, catalogue, settings.study, callbacks.progress);
  give_notes(record.study.notes, callbacks.note);
  const stand::Inventory& trees = record.inventory.inventory;
  add_stand(unit_options_of(settings, trees), design_of(settings, trees), catalogue, record);
  record.decisions = decisions_of(record);
  return record;
}

std::string study_configuration_for(const data::TableSource& inventory,
                                    const Catalogue& catalogue,
                                    const StudyConfiguration& settings,
                                    const Callbacks& callbacks) {
  const stand::CheckedInventory read =
      read_inventory(inventory, settings.reading, {.keep_all = true}, callbacks.note);
  return study_configuration_for(stand::to_table(read.inventory), catalogue, settings);
}

ordered_json json_of(const StudyRecord& record, const std::filesystem::path& folder) {
  std::vector<std::string> notes = record.inventory.notes;
  notes.insert(notes.end(), record.study.notes.begin(), record.study.notes.end());
  ordered_json summary{{"schema", "silvafit-study/1"},
                       {"silvafit", record.version},
                       {"out", folder.string()},
                       {"report", (folder / "report.html").string()},
                       {"fits", record.study.fit_count()},
                       {"recognized", record.inventory.recognized},
                       {"notes", notes},
                       {"results", ordered_json::array()}};
  for (const ResponseStudy& result : record.study.results) {
    summary["results"].push_back(result_json(result));
  }
  return summary;
}

}  // namespace silvafit::study
