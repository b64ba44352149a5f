// SPDX-License-Identifier: MIT
// What a study leaves in its folder: library, tables, predictions, report.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/study.hpp"

namespace silvafit::study {

/// A study with all that it was made from, so that its files can speak for themselves.
struct StudyRecord {
  std::string version{};  ///< of the program
  std::string command{};  ///< the command line as it was given
  /// Decisions before fitting, for reading: window, edge correction, ...
  std::vector<std::pair<std::string, std::string>> decisions{};
  stand::CheckedInventory inventory{};
  std::optional<stand::StructuralUnits> units{};
  data::Table table{};  ///< inventory_table of the two
  Study study{};
};

/// An inventory with its structural units as one table: our column names, W, M, U, C, core, and
/// the further indices that were computed.
data::Table inventory_table(const stand::Inventory& inventory,
                            const std::optional<stand::StructuralUnits>& units);

/// The chosen models of all species and responses.
ModelLibrary library_of(const StudyRecord& record);

/// Per tree: the inventory, then for each response h_ols, h_population, h_conditional, ... (least
/// squares of level 1; mixed model with b = 0; mixed model with the plot's EBLUP).
data::Table predictions_of(const StudyRecord& record, const ModelLibrary& library);

/// Writes the tables of a study into a folder, each as CSV, Markdown (.md) and LaTeX (.tex):
/// species (importance values), candidates (level 1), covariates (level 2), random_effects and
/// variance_functions (level 3), estimates, variance_components, statistics, gains, level_tests.
void write_study_tables(const StudyRecord& record,
                        const Catalogue& catalogue,
                        const std::filesystem::path& folder);

/// The data of the report page, as docs/report-data.md describes them.
std::string report_data(const StudyRecord& record, const Catalogue& catalogue);

/// Writes everything into a folder: library.json, indices.csv (if there are units),
/// predictions.csv, excluded.csv, tables/, report.html and run.json. Each file is written whole or
/// not at all. \param page_template  the bundled report page
void write_study(const StudyRecord& record,
                 const Catalogue& catalogue,
                 const std::filesystem::path& page_template,
                 const std::filesystem::path& folder);

}  // namespace silvafit::study
