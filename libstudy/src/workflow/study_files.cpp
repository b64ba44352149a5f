// SPDX-License-Identifier: MIT
#include "silvafit/study/study_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "report/report_json.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/fingerprint.hpp"
#include "silvafit/base/io_error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/predict_responses.hpp"
#include "silvafit/study/report_page.hpp"
#include "silvafit/study/scenes.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

void add_model(const ResponseStudy& result,
               const std::optional<fit::FitResult>& fit,
               const std::string& role,
               ModelLibrary& library) {
  if (!fit) return;
  library.models.push_back({.species = result.species,
                            .response = result.response,
                            .unit = unit_of(result.response),
                            .role = role,
                            .fit = fit->fit});
  // Libraries of the same study would differ in wall times.
  library.models.back().fit.seconds = 0.0;
}

/// Of the species that were studied, by all of their trees.
std::map<std::string, double> commonest_diameters(const StudyRecord& record) {
  std::map<std::string, std::vector<double>> diameters;
  for (const ResponseStudy& result : record.study.results) diameters[result.species];
  const stand::Inventory& inventory = record.inventory.inventory;
  for (std::size_t row = 0; row < inventory.size(); ++row) {
    if (inventory.species.is_missing(row) || std::isnan(inventory.dbh_cm[row])) continue;
    const auto own = diameters.find(std::string(inventory.species[row]));
    if (own != diameters.end()) own->second.push_back(inventory.dbh_cm[row]);
  }
  std::map<std::string, double> result;
  for (const auto& [species, values] : diameters) {
    if (!values.empty()) result[species] = commonest_dbh_cm(values);
  }
  return result;
}

/// Adds the predictions of one kind under names such as h_ols.
void add_predictions(const ModelLibrary& library,
                     const PredictionSettings& settings,
                     const std::string& suffix,
                     const data::Table& trees,
                     data::Table& target) {
  const bool has_role = std::ranges::any_of(
      library.models, [&](const LibraryModel& model) { return model.role == settings.role; });
  if (!has_role) return;
  for (PredictedResponse& predicted : predict_responses(library, trees, settings).responses) {
    target.set(predicted.response + suffix, std::move(predicted.value));
  }
}

std::string run_json(const StudyRecord& record,
                     const ModelLibrary& library,
                     const std::filesystem::path& folder) {
  StudyConfiguration settings = seen_from(folder, record.settings);
  settings.study = record.study.options;
  ordered_json run{
      {"schema", "silvafit-run/1"},
      {"silvafit", record.version},
      {"command", record.command},
      {"input",
       {{"file", record.inventory.inventory.file}, {"fingerprint", library.inventory.fingerprint}}},
      {"options", settings_json(settings)},
      {"recognized", record.inventory.recognized},
      {"decisions", ordered_json::object()},
      {"fits", record.study.fit_count()},
      {"stages", ordered_json::array()}};
  for (const auto& [name, value] : record.decisions) run["decisions"][name] = value;
  for (const StageTime& stage : record.study.stages) {
    run["stages"].push_back(
        {{"name", stage.name}, {"fits", stage.fits}, {"seconds", stage.seconds}});
  }
  run["results"] = ordered_json::array();
  for (const ResponseStudy& result : record.study.results) {
    run["results"].push_back({{"species", result.species},
                              {"response", result.response},
                              {"converged", result.converged()},
                              {"verdict", result.verdict()},
                              {"sound", result.is_sound()},
                              {"doubts", result.doubts},
                              {"left_out", left_out_object(result)}});
  }
  return json_text(run, 2) + "\n";
}

/// Files of an earlier study could be mistaken for those of this one.
void remove_earlier_indices(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove(path, error);
  if (!error) return;
  throw IoError(fmt::format("belongs to an earlier study and cannot be removed ({}); remove it, "
                            "or choose another folder",
                            error.message()),
                {.file = path.string()});
}

}  // namespace

data::Table inventory_table(const stand::Inventory& inventory,
                            const std::optional<stand::StructuralUnits>& units) {
  data::Table table = stand::to_table(inventory);
  if (!units) {
    // Dead trees are used as neighbors only, not in models.
    if (inventory.neighbor_only.empty()) return table;
    std::vector<double> core(inventory.size(), 1.0);
    for (std::size_t i = 0; i < core.size(); ++i) core[i] = inventory.is_neighbor_only(i) ? 0 : 1;
    table.set("core", std::move(core));
    return table;
  }
  table.set("core", std::vector<double>(units->core.begin(), units->core.end()));
  table.set("W", units->W);
  table.set("M", units->M);
  table.set("U", units->U);
  if (!units->C.empty()) table.set("C", units->C);
  if (!units->weight.empty()) table.set("weight", units->weight);
  for (const stand::FurtherValues& further : units->further) {
    table.set(word_of(further.index), further.values);
  }
  return table;
}

ModelLibrary library_of(const StudyRecord& record) {
  const std::string& file = record.inventory.inventory.file;
  ModelLibrary library{.inventory = {.file = std::filesystem::path(file).filename().string(),
                                     .fingerprint = inventory_fingerprint(record),
                                     .trees = record.inventory.inventory.size()}};
  library.inventory.commonest_dbh_cm = commonest_diameters(record);
  if (record.units) library.inventory.units = record.settings.units;
  for (const ResponseStudy& result : record.study.results) {
    add_model(result, result.ols, "ols", library);
    add_model(result, result.with_covariates, "covariates", library);
    add_model(result, result.nlme, "nlme", library);
  }
  return library;
}

data::Table predictions_of(const StudyRecord& record, const ModelLibrary& library) {
  data::Table table = record.table;
  add_predictions(
      library, {.level = fit::Level::kPopulation, .role = "ols"}, "_ols", record.table, table);
  add_predictions(library,
                  {.level = fit::Level::kPopulation, .role = "nlme"},
                  "_population",
                  record.table,
                  table);
  add_predictions(library,
                  {.level = fit::Level::kConditional, .role = "nlme"},
                  "_conditional",
                  record.table,
                  table);
  return table;
}

void write_study(const StudyRecord& record,
                 const Catalogue& catalogue,
                 const std::filesystem::path& page_template,
                 const std::filesystem::path& folder) {
  const ModelLibrary library = library_of(record);
  write_library(library, folder / "library.json");
  if (record.units) {
    std::ostringstream units;
    stand::write_structural_units(record.inventory.inventory, *record.units, units);
    write_file(folder / "indices.csv", units.str());
  } else {
    remove_earlier_indices(folder / "indices.csv");
  }
  data::write_csv_table(predictions_of(record, library), folder / "predictions.csv");
  stand::write_excluded(record.inventory.excluded, folder / "excluded.csv");
  write_study_tables(record, catalogue, folder / "tables");
  const std::string title =
      "silvafit: " + std::filesystem::path(record.inventory.inventory.file).filename().string();
  write_report_page(page_template, report_data(record, catalogue), title, folder / "report.html");
  write_file(folder / "run.json", run_json(record, library, folder));
}

}  // namespace silvafit::study
