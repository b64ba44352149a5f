// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_growth.hpp"

#include <chrono>
#include <nlohmann/json.hpp>

#include "silvafit/study/indices.hpp"
#include "workflow/stand_options.hpp"

namespace silvafit::study {

GrowthSummary stand_growth(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks) {
  const auto start = std::chrono::steady_clock::now();
  const stand::StandReportOptions report = report_options(options);
  const stand::InventoryOptions reading{.keep = columns_of(options),
                                        .refuses_unread = true,
                                        .keeps_expansion = true,
                                        .keeps_measurements = true};
  GrowthSummary summary{.inventory =
                            read_inventory(inventory, options.reading, reading, callbacks.note)};
  const std::vector<std::string> on_equations =
      add_quantities(options, summary.inventory.inventory);
  summary.report = stand::growth_report(summary.inventory.inventory, report);
  summary.notes = complete_notes(
      report, on_equations, summary.inventory.notes, summary.report.notes, callbacks);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  summary.seconds = elapsed.count();
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
