// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_summary.hpp"

#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "workflow/flow.hpp"
#include "workflow/stand_options.hpp"

namespace silvafit::study {
namespace {

/// One batch is read while another one is added, with its structural units.
constexpr std::size_t kRowsOfBatch = 50000;

void refuse_expansion(const stand::Inventory& trees, const stand::StandReportOptions& report) {
  const bool has_areas = report.plot_area_m2 || !report.units.windows.empty();
  if (trees.expansion.empty() || has_areas) return;
  throw UsageError(
      "the trees of this table of FIA have factors (TPA_UNADJ), a sampling design, with which "
      "`stream` cannot be combined; omit `stream`, or give `plot_area` or `window`",
      {.file = trees.file, .column = "`stream`"});
}

/// The report of batches of whole plots, which are added up.
void add_parts(InventoryFlow& flow,
               const stand::StandReportOptions& report,
               const std::function<void(stand::Inventory&)>& add_quantities,
               const Callbacks& callbacks,
               const StandUnitSink& sink,
               StandSummary& summary) {
  // A stand of one plot has other quadrats than one of several.
  std::vector<stand::CheckedInventory> first;
  std::size_t plots = 0;
  while (plots < 2) {
    std::optional<stand::CheckedInventory> batch = flow.next();
    if (!batch) break;
    plots += batch->inventory.plot.levels().size();
    first.push_back(std::move(*batch));
  }
  stand::StandReportParts parts(report, plots < 2);
  std::size_t count = 0;
  const auto take = [&](stand::CheckedInventory& batch) {
    stand::Inventory& trees = batch.inventory;
    refuse_expansion(trees, report);
    summary.inventory.inventory.file = trees.file;
    summary.inventory.excluded_tree_count += batch.excluded_tree_count;
    add_quantities(trees);
    const stand::StructuralUnits* const units = parts.add(trees);
    if (sink && units != nullptr && trees.size() > 0) sink(batch, *units);
    count += trees.size();
    if (callbacks.progress) callbacks.progress(fmt::format("{} trees", count), 0, 1);
  };
  for (stand::CheckedInventory& batch : first) take(batch);
  first.clear();
  while (auto batch = flow.next()) take(*batch);
  summary.inventory.notes = flow.notes();
  summary.inventory.recognized = flow.recognized();
  summary.report = parts.finish(summary.inventory.inventory.file);
}

}  // namespace

StandSummary stand_summary(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks,
                           const StandUnitSink& sink) {
  const auto start = std::chrono::steady_clock::now();
  const stand::StandReportOptions report = report_options(options);
  StandSummary summary{.settings = options.units};
  InventoryFlow flow(
      inventory,
      options.reading,
      {.keep = columns_of(options), .refuses_unread = true, .keeps_expansion = !options.stream},
      {.is_in_parts = options.stream, .rows = kRowsOfBatch, .threads = options.threads},
      callbacks.note);
  QuantitiesOfParts quantities(options.equations);
  const auto add_quantities = [&](stand::Inventory& trees) {
    if (options.equations.equations.empty()) return;
    trees.quantities = quantities.add(stand::to_table(trees));
  };
  if (options.stream) {
    add_parts(flow, report, add_quantities, callbacks, sink, summary);
  } else {
    summary.inventory = std::move(*flow.next());
    add_quantities(summary.inventory.inventory);
    summary.report = stand::stand_report(summary.inventory.inventory, report);
    if (sink && summary.report.units) sink(summary.inventory, *summary.report.units);
  }
  summary.notes = complete_notes(
      report, quantities.notes(), summary.inventory.notes, summary.report.notes, callbacks);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  summary.seconds = elapsed.count();
  return summary;
}

nlohmann::ordered_json json_of(const StandSummary& summary) {
  nlohmann::ordered_json result{{"schema", "silvafit-stand/1"},
                                {"silvafit", SILVAFIT_VERSION},
                                {"inventory", summary.inventory.inventory.file},
                                {"excluded", summary.inventory.excluded_tree_count},
                                {"edge", summary.settings.edge},
                                {"per", summary.settings.per}};
  result.update(stand::json_of(summary.report));
  result["recognized"] = summary.inventory.recognized;
  result["notes"] = summary.notes;
  result["seconds"] = summary.seconds;
  return result;
}

}  // namespace silvafit::study
