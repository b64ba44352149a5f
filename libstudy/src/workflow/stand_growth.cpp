// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_growth.hpp"

#include <nlohmann/json.hpp>

#include "silvafit/study/indices.hpp"
#include "workflow/flow.hpp"
#include "workflow/stand_options.hpp"

namespace silvafit::study {

GrowthSummary stand_growth(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks) {
  refuse_idle_on_growth(options);
  const auto start = Clock::now();
  const stand::StandReportOptions report = report_options(options);
  const stand::InventoryOptions reading{.keep = columns_of(options),
                                        .refuses_unread = true,
                                        .keeps_expansion = true,
                                        .keeps_measurements = true};
  GrowthSummary summary{.inventory =
                            read_inventory(inventory, options.reading, reading, callbacks.note)};
  stand::Inventory& trees = summary.inventory.inventory;
  QuantitiesOfParts quantities(options.equations);
  if (!options.equations.equations.empty()) {
    trees.quantities = quantities.add(stand::to_table(trees));
  }
  add_totals(options.totals, trees);
  summary.report = stand::growth_report(trees, report);
  summary.notes = complete_notes(
      report, quantities.notes(), summary.inventory.notes, summary.report.notes, callbacks);
  summary.seconds = seconds_since(start);
  return summary;
}

nlohmann::ordered_json json_of(const GrowthSummary& summary) {
  nlohmann::ordered_json result{{"schema", "silvafit-growth/1"},
                                {"silvafit", SILVAFIT_VERSION},
                                {"inventory", summary.inventory.inventory.file},
                                {"excluded", summary.inventory.excluded_tree_count}};
  result.update(stand::json_of(summary.report));
  result["recognized"] = summary.inventory.recognized;
  result["notes"] = summary.notes;
  result["seconds"] = summary.seconds;
  return result;
}

}  // namespace silvafit::study
