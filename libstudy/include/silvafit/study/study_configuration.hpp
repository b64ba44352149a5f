// SPDX-License-Identifier: MIT
// A study's settings as a file written by users: study.json.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "silvafit/data/table.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/study.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// All settings of a study: how the inventory is read and sampled, its structural units, and its
/// models.
struct StudyConfiguration {
  StudyOptions study{};
  ReadingSettings reading{};
  UnitSettings units{};
  SamplingSettings sampling{};
};

/// A covariate counts as a further index.
/// \throws UsageError that names a setting without effect
void refuse_idle(const StudyConfiguration& settings, const GivenName& given_name = {});

/// Settings that have priority over those of a file.
struct GivenSettings {
  StudyConfiguration settings{};
  /// By the key of a setting; empty: none has priority.
  std::function<bool(std::string_view key)> is_given{};
};

/// Reads a study.json; docs/settings.md lists its keys. Missing keys have their defaults.
/// A window and a table of plots are relative to the folder of the file. Comments (`//`) are
/// allowed. The run.json of a study serves as well: its options are settings. \param catalogue  has
/// the models that candidates may name; null: they are not looked up \throws InputError that names
/// file and key where a key is unknown or a value cannot be used
StudyConfiguration read_study_configuration(const std::filesystem::path& path,
                                            const Catalogue* catalogue = nullptr,
                                            const GivenSettings& given = {});

/// The same settings for a file in another folder: a window and a table of plots become relative to
/// it; an absolute path is unchanged.
/// \param folder  empty: the current one
StudyConfiguration seen_from(const std::filesystem::path& folder, StudyConfiguration settings);

/// A study.json with every key, explained by comments, for the inventory at hand: its species, the
/// candidates of the responses that it has, and the columns that can serve as covariates.
/// \param table     an inventory with our column names
/// \param settings  to be written
std::string study_configuration_for(const data::Table& table,
                                    const Catalogue& catalogue,
                                    const StudyConfiguration& settings = {});

}  // namespace silvafit::study
