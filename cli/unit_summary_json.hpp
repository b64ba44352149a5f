// SPDX-License-Identifier: MIT
// Means of structural units as JSON, alike in `silvafit indices` and `silvafit stand`.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "silvafit/stand/unit_summary.hpp"

namespace silvafit::cli {

/// trees, core, W, M, U, C and the further indices by name; null where a mean is not known.
/// \param further  the indices of summary.further, in their order
nlohmann::ordered_json unit_summary_json(const stand::UnitSummary& summary,
                                         const std::vector<stand::FurtherIndex>& further);

}  // namespace silvafit::cli
