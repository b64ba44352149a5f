// SPDX-License-Identifier: MIT
// Growth between repeated measurements of an inventory, from a file or table to results.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/growth.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/callbacks.hpp"
#include "silvafit/study/stand_summary.hpp"

namespace silvafit::study {

/// \throws UsageError that names a setting without effect on growth
void refuse_idle_on_growth(const StandOptions& options, const GivenName& given_name = {});

struct GrowthSummary {
  stand::CheckedInventory inventory{};
  stand::GrowthReport report{};
  std::vector<std::string> notes{};  ///< on the inventory and the report
  double seconds = 0.0;
};

/// Reads an inventory with the rows of all times and computes the growth of trees, plots and
/// strata. stand::tables_of turns the report into tables.
/// \throws as stand_summary and stand::growth_report
GrowthSummary stand_growth(const data::TableSource& inventory,
                           const StandOptions& options = {},
                           const Callbacks& callbacks = {});

/// As JSON, schema silvafit-growth/1 (docs/plots.md).
nlohmann::ordered_json json_of(const GrowthSummary& summary);

}  // namespace silvafit::study
