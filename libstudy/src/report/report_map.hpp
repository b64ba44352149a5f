// SPDX-License-Identifier: MIT
// The plot map of the report page.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// Windows, stems, crowns and structural units, as docs/report-data.md describes them. Empty
/// without positions, or if there are so many trees that the page would be slow.
std::optional<nlohmann::ordered_json> report_map(const StudyRecord& record);

}  // namespace silvafit::study
