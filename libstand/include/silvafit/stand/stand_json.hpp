// SPDX-License-Identifier: MIT
// A stand report as JSON and as tables.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/stand/stand_report.hpp"
#include "silvafit/stand/unit_summary.hpp"

namespace silvafit::stand {

/// trees, core, W, M, U, C and the further indices; null where no core tree has the index.
/// \param further  names of UnitSummary::further
nlohmann::ordered_json json_of(const UnitSummary& summary,
                               const std::vector<FurtherIndex>& further);

/// areas, all, strata, species, diameters and structure, as docs/stand.md describes them.
nlohmann::ordered_json json_of(const StandReport& report);

/// Kind of a row of strata: "stratum", "none" (plots without one) or "all".
std::string_view name_of(StratumFigures::Kind kind);

/// The same as tables: plots, strata, species, diameters and, with positions, classes (the joint
/// distributions of two indices), each under its name.
std::vector<std::pair<std::string, data::Table>> tables_of(const StandReport& report);

}  // namespace silvafit::stand
