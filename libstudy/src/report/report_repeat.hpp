// SPDX-License-Identifier: MIT
// The data that is needed to repeat a study.
#pragma once

#include <nlohmann/json.hpp>

#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// `repeat` of docs/report-data.md: the fingerprint of the inventory's file (empty for a table in
/// memory), and the versions of the program and its libraries.
/// \throws InputError if the inventory no longer exists
nlohmann::ordered_json report_repeat(const StudyRecord& record);

/// Name and version of the program, the compiler and the numerical libraries that made it.
nlohmann::ordered_json report_versions();

}  // namespace silvafit::study
