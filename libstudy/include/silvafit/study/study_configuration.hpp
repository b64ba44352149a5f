// SPDX-License-Identifier: MIT
// A study's settings as a file that people write: study.json.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/study.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// What a study.json says. What it does not mention is empty, or the default of a study.
struct StudyConfiguration {
  StudyOptions study{};
  std::vector<std::string> mentioned{};  ///< keys of the file
  std::vector<std::string> columns{};    ///< `dbh=DBH_cm`: where the inventory's columns come from
  std::optional<std::string> window{};   ///< file, relative to that of the configuration
  std::optional<std::string> edge{};     ///< buffer, hanisch, torus or none
  std::optional<double> buffer_m{};
  std::optional<bool> trust_units{};
  std::vector<std::string> missing{};    ///< further texts and numbers for missing values
  std::vector<std::string> fill_down{};  ///< columns whose empty fields have the value above
  std::optional<std::string> dead{};     ///< leave-out, neighbors or include
  std::optional<bool> case_sensitive{};
  std::optional<std::string> circle{};  ///< `x,y,radius` of every plot
  std::optional<std::vector<std::string>> further{};
  UnitSettings units{};
};

/// Reads a study.json; docs/study.md lists its keys. Comments (`//`) are allowed. The run.json of a
/// study serves as well: its options are settings.
/// \param catalogue  has the models that candidates may name; null: they are not looked up
/// \throws InputError that names file and key where a key is unknown or a value cannot be used
StudyConfiguration read_study_configuration(const std::filesystem::path& path,
                                            const Catalogue* catalogue = nullptr);

/// A study.json with every key, explained by comments, for the inventory at hand: its species, the
/// candidates of the responses that it has, and the columns that can serve as covariates.
/// \param table     an inventory with our column names
/// \param settings  that the file is to hold
std::string study_configuration_for(const data::Table& table,
                                    const Catalogue& catalogue,
                                    const StudyConfiguration& settings = {});

}  // namespace silvafit::study
