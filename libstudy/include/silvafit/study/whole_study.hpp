// SPDX-License-Identifier: MIT
// A whole study: from an inventory and settings to models, and to the files of a folder.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "silvafit/data/csv.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/study_configuration.hpp"
#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// Reads the inventory, computes structural units where it has positions, and runs the three
/// levels. write_study() writes the record into a folder.
/// \param settings  a window is relative to the current folder
/// \throws UsageError if settings cannot be used; else as stand::read_inventory,
///   stand::structural_units and run_study
StudyRecord whole_study(const data::TableSource& inventory,
                        const Catalogue& catalogue,
                        const StudyConfiguration& settings,
                        const Callbacks& callbacks = {});

/// Reads an inventory and writes a configuration for it, see study_configuration_for().
std::string study_configuration_for(const data::TableSource& inventory,
                                    const Catalogue& catalogue,
                                    const StudyConfiguration& settings,
                                    const Callbacks& callbacks = {});

/// A summary of the results as JSON, schema silvafit-study/1 (docs/study.md).
/// \param folder  of the study's files
nlohmann::ordered_json json_of(const StudyRecord& record, const std::filesystem::path& folder);

}  // namespace silvafit::study
