// SPDX-License-Identifier: MIT
// Output of `silvafit stand`: text tables, JSON, and CSV files.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "silvafit/stand/stand_report.hpp"

namespace silvafit::cli {

/// Kind of a row of strata: "stratum", "none" (plots without one) or "all".
std::string_view kind_of(const stand::StratumFigures& stratum);

/// Tables on standard output.
void print_stand(const stand::StandReport& report);

/// areas, all, strata, species, diameters and structure, as docs/stand.md describes them.
nlohmann::ordered_json stand_json(const stand::StandReport& report);

/// Writes plots.csv, strata.csv, species.csv, diameters.csv and, with positions, classes.csv and
/// indices.csv into a folder.
void write_stand(const stand::Inventory& inventory,
                 const stand::StandReport& report,
                 const std::filesystem::path& folder);

}  // namespace silvafit::cli
