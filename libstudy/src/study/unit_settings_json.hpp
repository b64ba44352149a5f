// SPDX-License-Identifier: MIT
// Settings of structural units as JSON, with the keys of study.json.
#pragma once

#include <nlohmann/json.hpp>

#include "silvafit/data/json_reader.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::study {

/// Reads the keys of the search and of the indices, if present; other keys are ignored.
/// \throws InputError that names file and key where a value cannot be used
UnitSettings read_unit_settings(const data::JsonReader& json);

/// These keys with their values.
nlohmann::ordered_json unit_settings_json(const UnitSettings& settings);

}  // namespace silvafit::study
