// SPDX-License-Identifier: MIT
// The files that a study writes into its folder: library, tables, predictions, report.
#pragma once

#include <filesystem>
#include <optional>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

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

/// Writes everything into a folder: library.json, indices.csv (if there are units),
/// predictions.csv, excluded.csv, tables/, report.html and run.json. Each file is written whole or
/// not at all. Without units, the indices.csv of an earlier study is removed, because it is of
/// other trees.
/// \param page_template  the bundled report page
/// \throws IoError if a file cannot be written or removed
void write_study(const StudyRecord& record,
                 const Catalogue& catalogue,
                 const std::filesystem::path& page_template,
                 const std::filesystem::path& folder);

}  // namespace silvafit::study
