// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "silvafit/base/error.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/read_ahead.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/indices.hpp"
#include "silvafit/study/report_data.hpp"
#include "silvafit/study/report_page.hpp"
#include "silvafit/study/site_index.hpp"
#include "silvafit/study/study_files.hpp"
#include "workflow/report_stand.hpp"
#include "workflow/stand_options.hpp"
#include "workflow/study_decisions.hpp"

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
        "the trees of this inventory have factors of trees per ha, a sampling design, with which "
        "`stream` cannot be combined; omit `stream`, or give `plot_area` or `window`",
        {.file = trees.file, .column = "`stream`"});
  }
  summary.inventory.inventory.file = trees.file;
  summary.inventory.excluded_tree_count += batch.excluded_tree_count;
  if (!options_.equations.equations.empty()) {
    trees.quantities = quantities_.add(stand::to_table(trees));
  }
  add_totals(options_.totals, trees);
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

void add_thinning(const StandOptions& options,
                  const stand::StandReportOptions& report,
                  StandSummary& summary) {
  if (options.thinning.empty()) return;
  const stand::Inventory& trees = summary.inventory.inventory;
  const bool has_areas = report.plot_area_m2 || !report.units.windows.empty();
  if (report.design.chooses_trees() || (!trees.expansion.empty() && !has_areas)) {
    throw UsageError(
        "a thinning needs plots of which all trees were counted; in samples of trees the removed "
        "ones stand for others",
        {.column = "`thinning`"});
  }
  summary.thinning = stand::thin(trees, summary.report, stand::parse_thinning(options.thinning));
}

void add_site_indices(const StandOptions& options, StandSummary& summary) {
  if (options.site_index.empty()) return;
  const std::vector<SiteCurve> curves = load_site_curves(options.equations.models);
  const SiteCurve& curve = site_curve(curves, options.site_index);
  const stand::Inventory& trees = summary.inventory.inventory;
  if (!trees.other.is_numeric("age")) {
    throw InputError(
        "a site index needs the ages of trees in years; name their column with "
        "`columns=age=COLUMN`",
        {.file = trees.file, .column = "age"});
  }
  const auto ages = trees.other.numbers("age");
  std::size_t outside = 0;
  for (const stand::AreaReport& area : summary.report.areas) {
    double sum = 0.0;
    double count = 0.0;
    for (const std::size_t tree : area.area.trees) {
      if (std::isnan(ages[tree])) continue;
      sum += ages[tree];
      count += 1.0;
    }
    SiteIndex site{.plot = area.area.name,
                   .age = count > 0.0 ? sum / count : data::kMissing,
                   .dominant_m = area.figures.dominant_height_m};
    site.at_base_age = curve.site_index(site.dominant_m, site.age);
    if (site.age < curve.lowest_age || site.age > curve.highest_age) ++outside;
    summary.sites.push_back(std::move(site));
  }
  summary.report.notes.push_back(
      fmt::format("site index: dominant height at {} years by the curve of {} ({}), with the mean "
                  "age of the trees of a plot",
                  curve.base_age,
                  curve.title,
                  curve.id));
  if (outside == 0) return;
  summary.report.notes.push_back(fmt::format("{} outside the ages of the curve, {} to {} years",
                                             counted(outside, "plot is", "plots are"),
                                             curve.lowest_age,
                                             curve.highest_age));
}

/// \return notes on equations
std::vector<std::string> read_in_parts(const data::TableSource& inventory,
                                       const StandOptions& options,
                                       const stand::StandReportOptions& report,
                                       const Callbacks& callbacks,
                                       const StandUnitSink& sink,
                                       StandSummary& summary) {
  if (!options.thinning.empty() || !options.site_index.empty()) {
    throw UsageError("a thinning and site indices need all trees in memory; omit `stream`",
                     {.column = "`stream`"});
  }
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
  add_thinning(options, report, summary);
  add_site_indices(options, summary);
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
  for (std::string& note : notes_on_totals(options, summary.report)) {
    summary.report.notes.push_back(std::move(note));
  }
  summary.notes = complete_notes(
      report, on_equations, summary.inventory.notes, summary.report.notes, callbacks);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  summary.seconds = elapsed.count();
  return summary;
}

std::vector<std::pair<std::string, data::Table>> tables_of(const StandSummary& summary) {
  auto tables = stand::tables_of(summary.report);
  if (summary.thinning) {
    std::vector<stand::ThinningFigures> plots = summary.thinning->plots;
    plots.push_back(summary.thinning->all);
    plots.back().name = "all";
    data::Table table(plots.size());
    data::TextColumn names;
    for (const stand::ThinningFigures& plot : plots) names.append(plot.name);
    table.set("plot", std::move(names));
    using Figures = stand::StandFigures;
    using Stage = std::pair<const char*, Figures stand::ThinningFigures::*>;
    using Column = std::pair<const char*, double Figures::*>;
    for (const auto& [value, member] :
         {Column{"stems_per_ha", &Figures::stems_per_ha},
          Column{"basal_area_m2_per_ha", &Figures::basal_area_m2_per_ha},
          Column{"quadratic_mean_dbh_cm", &Figures::quadratic_mean_dbh_cm},
          Column{"mean_height_m", &Figures::mean_height_m},
          Column{"dominant_height_m", &Figures::dominant_height_m}}) {
      for (const auto& [stage, figures] : {Stage{"before", &stand::ThinningFigures::before},
                                           Stage{"removed", &stand::ThinningFigures::removed},
                                           Stage{"after", &stand::ThinningFigures::after}}) {
        std::vector<double> values;
        for (const stand::ThinningFigures& plot : plots) values.push_back(plot.*figures.*member);
        table.set(fmt::format("{}_{}", value, stage), std::move(values));
      }
    }
    tables.emplace_back("thinning", std::move(table));
    data::Table trees = stand::to_table(summary.inventory.inventory);
    const std::vector<char>& removed = summary.thinning->is_removed;
    trees.set("removed", std::vector<double>(removed.begin(), removed.end()));
    tables.emplace_back("trees", std::move(trees));
  }
  if (!summary.sites.empty()) {
    data::Table table(summary.sites.size());
    data::TextColumn names;
    std::array<std::vector<double>, 3> values;
    for (const SiteIndex& site : summary.sites) {
      names.append(site.plot);
      values[0].push_back(site.age);
      values[1].push_back(site.dominant_m);
      values[2].push_back(site.at_base_age);
    }
    table.set("plot", std::move(names));
    table.set("age", std::move(values[0]));
    table.set("dominant_height_m", std::move(values[1]));
    table.set("site_index_m", std::move(values[2]));
    tables.emplace_back("sites", std::move(table));
  }
  return tables;
}

void write_stand_page(StandSummary summary,
                      const StandOptions& options,
                      const Catalogue& catalogue,
                      const std::string& command,
                      const std::filesystem::path& page_template,
                      const std::filesystem::path& file) {
  if (options.stream) {
    throw UsageError("a report needs all trees in memory; omit `stream` or `report`",
                     {.column = "`report`"});
  }
  StudyRecord record{.version = SILVAFIT_VERSION,
                     .command = command,
                     .settings = {.reading = options.reading,
                                  .units = options.units,
                                  .sampling = options.sampling},
                     .inventory = std::move(summary.inventory)};
  record.units = summary.report.units;
  record.table = inventory_table(record.inventory.inventory, record.units);
  record.height_curves = height_curves_of(record.inventory.inventory, catalogue);
  if (!options.equations.equations.empty()) {
    record.volume = fmt::format("equations {}", fmt::join(options.equations.equations, ", "));
  }
  record.decisions = decisions_of(record);
  record.inventory.notes = std::move(summary.notes);
  record.stand = std::move(summary.report);
  const std::string title =
      "silvafit: " + std::filesystem::path(record.inventory.inventory.file).filename().string();
  write_report_page(page_template, report_data(record, catalogue), title, file);
}

nlohmann::ordered_json json_of(const StandSummary& summary) {
  nlohmann::ordered_json result{{"schema", "silvafit-stand/1"},
                                {"silvafit", SILVAFIT_VERSION},
                                {"inventory", summary.inventory.inventory.file},
                                {"excluded", summary.inventory.excluded_tree_count},
                                {"edge", summary.settings.edge},
                                {"per", summary.settings.per}};
  result.update(stand::json_of(summary.report));
  if (summary.thinning) {
    const auto thinning_json = [&](const stand::ThinningFigures& plot) {
      const auto figures = [](const stand::StandFigures& one) {
        return nlohmann::ordered_json{
            {"trees", one.trees},
            {"stems_per_ha", number_or_null(one.stems_per_ha)},
            {"basal_area_m2_per_ha", number_or_null(one.basal_area_m2_per_ha)},
            {"quadratic_mean_dbh_cm", number_or_null(one.quadratic_mean_dbh_cm)},
            {"dominant_height_m", number_or_null(one.dominant_height_m)}};
      };
      return nlohmann::ordered_json{{"plot", text_or_null(plot.name)},
                                    {"before", figures(plot.before)},
                                    {"removed", figures(plot.removed)},
                                    {"after", figures(plot.after)}};
    };
    result["thinning"] = {{"plots", nlohmann::ordered_json::array()},
                          {"all", thinning_json(summary.thinning->all)}};
    for (const stand::ThinningFigures& plot : summary.thinning->plots) {
      result["thinning"]["plots"].push_back(thinning_json(plot));
    }
  }
  for (const SiteIndex& site : summary.sites) {
    result["sites"].push_back({{"plot", text_or_null(site.plot)},
                               {"age", number_or_null(site.age)},
                               {"dominant_height_m", number_or_null(site.dominant_m)},
                               {"site_index_m", number_or_null(site.at_base_age)}});
  }
  result["recognized"] = summary.inventory.recognized;
  result["notes"] = summary.notes;
  result["seconds"] = summary.seconds;
  return result;
}

}  // namespace silvafit::study
