// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_summary.hpp"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "silvafit/base/error.hpp"
#include "silvafit/base/read_ahead.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/indices.hpp"
#include "workflow/stand_options.hpp"

namespace silvafit::study {
namespace {

/// Reads an inventory in batches of whole plots and adds them up.
class BatchesOfStand {
 public:
  BatchesOfStand(const std::filesystem::path& file,
                 const StandOptions& options,
                 const stand::StandReportOptions& report,
                 const Callbacks& callbacks,
                 const StandUnitSink& sink)
      : options_(options),
        report_(report),
        callbacks_(callbacks),
        sink_(sink),
        batches_(file,
                 inventory_options(options.reading,
                                   {.keep = columns_of(options), .refuses_unread = true}),
                 kTreesOfBatch),
        quantities_(options.equations) {}

  void run(StandSummary& summary);
  std::vector<std::string> notes_on_equations() const { return quantities_.notes(); }

 private:
  /// One batch is read while another one is added, with its structural units.
  static constexpr std::size_t kTreesOfBatch = 50000;

  void take(stand::CheckedInventory& batch, stand::StandReportParts& parts, StandSummary& summary);

  const StandOptions& options_;
  const stand::StandReportOptions& report_;
  const Callbacks& callbacks_;
  const StandUnitSink& sink_;
  stand::InventoryBatches batches_;
  QuantitiesOfParts quantities_;
  std::size_t trees_ = 0;
};

void BatchesOfStand::take(stand::CheckedInventory& batch,
                          stand::StandReportParts& parts,
                          StandSummary& summary) {
  stand::Inventory& trees = batch.inventory;
  const bool has_areas = report_.plot_area_m2 || !report_.units.windows.empty();
  if (!trees.expansion.empty() && !has_areas) {
    throw UsageError(
        "the trees of this table of FIA have factors (TPA_UNADJ), a sampling design, with which "
        "`stream` cannot be combined; omit `stream`, or give `plot_area` or `window`",
        {.file = trees.file, .column = "`stream`"});
  }
  summary.inventory.inventory.file = trees.file;
  summary.inventory.excluded_tree_count += batch.excluded_tree_count;
  if (!options_.equations.equations.empty()) {
    trees.quantities = quantities_.add(stand::to_table(trees));
  }
  const stand::StructuralUnits* const units = parts.add(trees);
  if (sink_ && units != nullptr && trees.size() > 0) sink_(batch, *units);
  trees_ += trees.size();
  if (callbacks_.progress) callbacks_.progress(fmt::format("{} trees", trees_), 0, 1);
}

void BatchesOfStand::run(StandSummary& summary) {
  std::vector<std::string>& notes = summary.inventory.notes;
  if (batches_.is_sorted()) {
    notes.emplace_back(kSortedNote);
    give_notes(notes, callbacks_.note);
  }
  // A stand of one plot has other quadrats than one of several.
  std::vector<stand::CheckedInventory> first;
  std::size_t plots = 0;
  while (plots < 2) {
    std::optional<stand::CheckedInventory> batch = batches_.next();
    if (!batch) break;
    plots += batch->inventory.plot.levels().size();
    first.push_back(std::move(*batch));
  }
  stand::StandReportParts parts(report_, plots < 2);
  for (stand::CheckedInventory& batch : first) take(batch, parts, summary);
  first.clear();
  ReadAhead<std::optional<stand::CheckedInventory>> ahead([this] { return batches_.next(); },
                                                          options_.threads);
  while (auto batch = ahead.next()) take(*batch, parts, summary);
  give_notes(batches_.notes(), callbacks_.note);
  for (std::string& note : batches_.notes()) notes.push_back(std::move(note));
  summary.inventory.recognized = batches_.recognized();
  const std::string excluded = batches_.excluded();
  if (!excluded.empty() && callbacks_.note) callbacks_.note(excluded);
  summary.report = parts.finish(summary.inventory.inventory.file);
}

/// \return notes on equations
std::vector<std::string> read_in_parts(const data::TableSource& inventory,
                                       const StandOptions& options,
                                       const stand::StandReportOptions& report,
                                       const Callbacks& callbacks,
                                       const StandUnitSink& sink,
                                       StandSummary& summary) {
  const auto* const file = std::get_if<std::filesystem::path>(&inventory);
  if (file == nullptr) {
    throw UsageError("only CSV files can be read plot by plot", {.column = "`stream`"});
  }
  BatchesOfStand batches(*file, options, report, callbacks, sink);
  batches.run(summary);
  return batches.notes_on_equations();
}

/// \return notes on equations
std::vector<std::string> read_whole(const data::TableSource& inventory,
                                    const StandOptions& options,
                                    const stand::StandReportOptions& report,
                                    const Callbacks& callbacks,
                                    const StandUnitSink& sink,
                                    StandSummary& summary) {
  const stand::InventoryOptions reading{
      .keep = columns_of(options), .refuses_unread = true, .keeps_expansion = true};
  summary.inventory = read_inventory(inventory, options.reading, reading, callbacks.note);
  std::vector<std::string> notes = add_quantities(options, summary.inventory.inventory);
  summary.report = stand::stand_report(summary.inventory.inventory, report);
  if (sink && summary.report.units) sink(summary.inventory, *summary.report.units);
  return notes;
}

}  // namespace

StandSummary stand_summary(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks,
                           const StandUnitSink& sink) {
  const auto start = std::chrono::steady_clock::now();
  const stand::StandReportOptions report = report_options(options);
  StandSummary summary{.settings = options.units};
  const auto read = options.stream ? read_in_parts : read_whole;
  const std::vector<std::string> on_equations =
      read(inventory, options, report, callbacks, sink, summary);
  summary.notes = complete_notes(
      report, on_equations, summary.inventory.notes, summary.report.notes, callbacks);
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
