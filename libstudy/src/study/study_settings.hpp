// SPDX-License-Identifier: MIT
// The settings of a study as JSON: the keys of study.json, also written to run.json.
#pragma once

#include <nlohmann/json.hpp>

#include "silvafit/study/study_configuration.hpp"

namespace silvafit::study {

/// Every key of study.json with its value.
nlohmann::ordered_json settings_json(const StudyConfiguration& settings);

}  // namespace silvafit::study
