// SPDX-License-Identifier: MIT
// Tables of the report page.
#pragma once

#include <nlohmann/json.hpp>

#include "study/formatted_table.hpp"

namespace silvafit::study {

/// As docs/report-data.md describes `tables`.
nlohmann::ordered_json json_of(const FormattedTable& table);

}  // namespace silvafit::study
