// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_summary.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/stand_growth.hpp"
#include "workflow/flow.hpp"

namespace silvafit::study {
namespace {

/// \param result  what comes before the report
template <class Summary>
nlohmann::ordered_json json_of(const Summary& summary, nlohmann::ordered_json result) {
  result.update(stand::json_of(summary.report));
  result["recognized"] = summary.inventory.recognized;
  result["notes"] = summary.notes;
  result["seconds"] = summary.seconds;
  return result;
}

void check_stratum_areas(const stand::StandReportOptions& options) {
  const bool has_strata =
      !options.stratum.empty() || (options.design.plots && options.design.plots->has_stratum);
  if (!options.stratum_areas_ha.empty() && !has_strata) {
    throw UsageError(
        "`stratum_areas` needs the strata: `stratum=COLUMN`, or the column stratum in "
        "the table of `plots`",
        {.column = "`stratum_areas`"});
  }
}

/// With windows and the table of plots read.
/// \throws UsageError if settings cannot be used
stand::StandReportOptions report_options(const StandOptions& options) {
  stand::StandReportOptions report = options.report;
  report.units = unit_options(options.units, options.threads);
  report.design = sampling_design(options.sampling);
  report.trust_units = options.reading.trust_units;
  check_stratum_areas(report);
  return report;
}

/// Columns of the inventory that are needed besides ours.
std::vector<std::string> columns_of(const StandOptions& options) {
  std::vector<std::string> columns = columns_of(options.sampling);
  const std::vector<std::string> needed = columns_of(options.equations);
  columns.insert(columns.end(), needed.begin(), needed.end());
  if (!options.report.stratum.empty()) columns.push_back(options.report.stratum);
  return columns;
}

/// Adds the notes on equations and on the table of plots to those of a report, and passes all to
/// the caller.
/// \return those of the inventory and of the report
std::vector<std::string> complete_notes(const stand::StandReportOptions& options,
                                        const std::vector<std::string>& on_equations,
                                        const std::vector<std::string>& on_inventory,
                                        std::vector<std::string>& notes,
                                        const Callbacks& callbacks) {
  notes.insert(notes.end(), on_equations.begin(), on_equations.end());
  if (options.design.plots && !options.design.plots->recognized.empty()) {
    notes.insert(notes.begin(), "table of plots: " + options.design.plots->recognized);
  }
  give_notes(notes, callbacks.note);
  std::vector<std::string> all = on_inventory;
  all.insert(all.end(), notes.begin(), notes.end());
  return all;
}

/// Quantities of the equations for the trees of an inventory or of its parts.
class EquationsOfTrees {
 public:
  explicit EquationsOfTrees(const EquationSettings& settings) {
    if (!settings.equations.empty()) quantities_.emplace(settings);
  }

  void add_to(stand::Inventory& trees) {
    if (quantities_) trees.quantities = quantities_->add(stand::to_table(trees));
  }
  std::vector<std::string> notes() const {
    return quantities_ ? quantities_->notes() : std::vector<std::string>();
  }

 private:
  std::optional<QuantitiesOfParts> quantities_{};
};

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
               EquationsOfTrees& equations,
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
    equations.add_to(trees);
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
  const auto start = Clock::now();
  const stand::StandReportOptions report = report_options(options);
  StandSummary summary{.settings = options.units};
  InventoryFlow flow(
      inventory,
      options.reading,
      {.keep = columns_of(options), .refuses_unread = true, .keeps_expansion = !options.stream},
      {.is_in_parts = options.stream, .rows = kRowsOfBatch, .threads = options.threads},
      callbacks.note);
  EquationsOfTrees equations(options.equations);
  if (options.stream) {
    add_parts(flow, report, equations, callbacks, sink, summary);
  } else {
    summary.inventory = std::move(*flow.next());
    equations.add_to(summary.inventory.inventory);
    summary.report = stand::stand_report(summary.inventory.inventory, report);
    if (sink && summary.report.units) sink(summary.inventory, *summary.report.units);
  }
  summary.notes = complete_notes(
      report, equations.notes(), summary.inventory.notes, summary.report.notes, callbacks);
  summary.seconds = seconds_since(start);
  return summary;
}

GrowthSummary stand_growth(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks) {
  const auto start = Clock::now();
  const stand::StandReportOptions report = report_options(options);
  const stand::InventoryOptions reading{.keep = columns_of(options),
                                        .refuses_unread = true,
                                        .keeps_expansion = true,
                                        .keeps_measurements = true};
  GrowthSummary summary;
  summary.inventory =
      std::move(*InventoryFlow(inventory, options.reading, reading, {}, callbacks.note).next());
  EquationsOfTrees equations(options.equations);
  equations.add_to(summary.inventory.inventory);
  summary.report = stand::growth_report(summary.inventory.inventory, report);
  summary.notes = complete_notes(
      report, equations.notes(), summary.inventory.notes, summary.report.notes, callbacks);
  summary.seconds = seconds_since(start);
  return summary;
}

nlohmann::ordered_json json_of(const StandSummary& summary) {
  return json_of(summary,
                 {{"schema", "silvafit-stand/1"},
                  {"silvafit", SILVAFIT_VERSION},
                  {"inventory", summary.inventory.inventory.file},
                  {"excluded", summary.inventory.excluded_tree_count},
                  {"edge", summary.settings.edge},
                  {"per", summary.settings.per}});
}

nlohmann::ordered_json json_of(const GrowthSummary& summary) {
  return json_of(summary,
                 {{"schema", "silvafit-growth/1"},
                  {"silvafit", SILVAFIT_VERSION},
                  {"inventory", summary.inventory.inventory.file},
                  {"excluded", summary.inventory.excluded_tree_count}});
}

}  // namespace silvafit::study
