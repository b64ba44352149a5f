// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/list_table.hpp"
#include "silvafit/data/missing_codes.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/indices.hpp"
#include "silvafit/study/report_page.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/site_index.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/tree/species_map.hpp"
#include "study/settings_json.hpp"
#include "workflow/flow.hpp"
#include "workflow/report_parts.hpp"

namespace silvafit::study {
namespace {

/// Settings that growth does not read: those of tables of one time, and of neighbors.
constexpr auto kIdleOnGrowth = std::to_array<std::string_view>({"layers",
                                                                "quadrat",
                                                                "dominant_trees",
                                                                "class_width",
                                                                "thinning",
                                                                "site_index",
                                                                "by",
                                                                "dead",
                                                                "edge",
                                                                "buffer",
                                                                "further",
                                                                "per",
                                                                "alpha",
                                                                "neighbors",
                                                                "dominance",
                                                                "crowding",
                                                                "competition_radius",
                                                                "open_grown"});

/// Settings of a design, which plots whose areas are given do not have.
constexpr auto kOfSamples =
    std::to_array<std::string_view>({"subplots", "subplot", "slope_correction"});
constexpr auto kDesigns = std::to_array<std::string_view>({"circles", "angle_count", "expansion"});

IdleReasons idle_in_stand(const StandOptions& options, bool is_growth) {
  IdleReasons idle;
  const UnitSettings& units = options.units;
  const bool has_areas = options.report.plot_area_m2 || !units.window.empty() ||
                         !units.circle.empty() || !units.windows.empty();
  if (!has_areas) return idle;
  constexpr const char* kBeside = "beside `plot_area`, `window` or `circle`, which give the areas";
  for (const std::string_view key : kOfSamples) idle[key] = kBeside;
  if (!is_growth) return idle;  // stand tables refuse both with more words
  for (const std::string_view key : kDesigns) idle[key] = kBeside;
  return idle;
}

void refuse_idle(const StandOptions& options,
                 const IdleReasons& reasons,
                 const GivenName& given_name) {
  refuse_idle_settings(options, given_name, reasons);
  refuse_idle_settings(options.reading, given_name, reasons);
  refuse_idle_settings(options.units, given_name, reasons);
  refuse_idle_settings(options.sampling, given_name, reasons);
  refuse_idle_settings(options.equations, given_name, reasons);
}

IdleReasons idle_without_strata(const stand::StandReportOptions& options) {
  if (!options.stratum.empty() || (options.design.plots && options.design.plots->has_stratum)) {
    return {};
  }
  constexpr const char* kStrata =
      "without strata: `stratum=COLUMN`, or the column stratum in the table of `plots`";
  return {{"stratum_areas", kStrata}, {"post_stratified", kStrata}};
}

/// With windows and the table of plots read.
/// \throws UsageError if settings cannot be used
stand::StandReportOptions report_options(const StandOptions& options) {
  stand::StandReportOptions report = options.report;
  report.units = unit_options(options.units, options.threads);
  report.design = sampling_design(options.sampling);
  report.trust_units = options.reading.trust_units;
  refuse_idle_settings(options, {}, idle_without_strata(report));
  return report;
}

/// Columns of the inventory that are needed besides ours.
std::vector<std::string> columns_of(const StandOptions& options) {
  std::vector<std::string> columns = columns_of(options.sampling);
  const std::vector<std::string> needed = columns_of(options.equations);
  columns.insert(columns.end(), needed.begin(), needed.end());
  if (!options.report.stratum.empty()) columns.push_back(options.report.stratum);
  columns.insert(columns.end(), options.totals.begin(), options.totals.end());
  if (!options.thinning.empty()) {
    const std::string column = stand::parse_thinning(options.thinning).column;
    if (!column.empty()) columns.push_back(column);
  }
  if (!options.site_index.empty()) columns.emplace_back("age");
  for (const std::string& column : options.report.by) {
    if (stand::tree_column(column) == nullptr) columns.push_back(column);
  }
  return columns;
}

/// Volumes and weights are not negative, so that -1 beside them is a code, too.
void refuse_lone_minus_one(std::span<const double> values, Place place) {
  const auto is_negative = [](double value) { return value < 0.0; };
  const auto count = std::ranges::count(values, -1.0);
  if (count == 0 || std::ranges::count_if(values, is_negative) != count) return;
  throw InputError(fmt::format("the value -1 in {} may be a code of missing values: if it is, use "
                               "`missing=-1`; if it is a measurement, use `trust_units=true`",
                               counted(static_cast<std::size_t>(count), "row", "rows")),
                   std::move(place));
}

/// Adds columns of the file as quantities.
/// \throws InputError if one is not a column of numbers, or has what may be a code
void add_totals(const StandOptions& options, stand::Inventory& inventory) {
  for (const std::string& column : options.totals) {
    if (std::ranges::count(options.totals, column) > 1) {
      throw UsageError(fmt::format("'{}' is given twice", column), {.column = "`totals`"});
    }
    const bool is_other = inventory.other.has(column);
    const data::Table table = is_other ? data::Table() : stand::to_table(inventory);
    const data::Table& source = is_other ? inventory.other : table;
    if (!source.has(column) || !source.is_numeric(column)) {
      throw InputError(source.has(column) ? fmt::format("'{}' is not a column of numbers", column)
                                          : data::no_such_column(column, source.names()),
                       {.file = inventory.file, .column = "`totals`"});
    }
    const auto values = source.numbers(column);
    if (!options.reading.trust_units) {
      const Place place{.file = inventory.file, .column = column};
      data::refuse_possible_code(values, place);
      refuse_lone_minus_one(values, place);
    }
    inventory.quantities.push_back({.name = column, .values = {values.begin(), values.end()}});
  }
}

/// The numbers of trees without a value.
std::vector<std::string> notes_on_totals(const stand::StandReport& report) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < report.quantities.size(); ++i) {
    const std::size_t without = report.all.trees_without_quantity[i];
    if (without == 0 || without == report.all.trees) continue;
    notes.push_back(
        fmt::format("{} no {}; sums do not include {}, and means are those of the others",
                    counted(without, "tree has", "trees have"),
                    report.quantities[i],
                    without == 1 ? "it" : "them"));
  }
  return notes;
}

/// Adds the notes on equations and on the table of plots to those of a report, and passes all
/// to the caller.
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

/// One batch is read while another one is added, with its structural units.
constexpr std::size_t kRowsOfBatch = 50000;

void refuse_expansion(const stand::Inventory& trees, const stand::StandReportOptions& report) {
  const bool has_areas = report.plot_area_m2 || !report.units.windows.empty();
  if (trees.expansion.empty() || has_areas) return;
  throw UsageError(
      "the trees of this inventory have factors of trees per ha, a sampling design, with which "
      "`stream` cannot be combined; omit `stream`, or give `plot_area` or `window`",
      {.file = trees.file, .column = "`stream`"});
}

/// The report of batches of whole plots, which are added up.
void add_parts(stand::InventoryBatches& flow,
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

/// \throws InputError if one is not above 0
void check_ages(const stand::Inventory& trees, std::span<const double> ages) {
  const auto wrong = std::ranges::find_if(ages, [](double age) { return age <= 0.0; });
  if (wrong == ages.end()) return;
  Place place = trees.place(static_cast<std::size_t>(wrong - ages.begin()));
  place.column = "age";
  throw InputError(
      fmt::format("{0} is no age; if it is a code of missing values, use `missing={0}`",
                  data::shortest(*wrong)),
      place);
}

/// Names the species of trees for which a curve was not made.
void note_other_species(const stand::Inventory& trees,
                        const SiteCurve& curve,
                        const tree::SpeciesMap& map,
                        std::vector<std::string>& notes) {
  std::vector<std::string> others;
  for (const std::string& species : trees.species.levels()) {
    const tree::SpeciesMap::Species* const known = map.find(species);
    const std::string& latin = known == nullptr ? species : known->latin;
    if (std::ranges::find(curve.species, latin) == curve.species.end()) others.push_back(species);
  }
  if (others.empty()) return;
  notes.push_back(fmt::format("the curve was made for {}, but there are trees of {}",
                              fmt::join(curve.species, " and "),
                              data::list_of(others)));
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
  check_ages(trees, ages);
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
    if (!std::isnan(site.age) && !curve.has_age(site.age)) ++outside;
    summary.sites.push_back(std::move(site));
  }
  summary.report.notes.push_back(
      fmt::format("site index: dominant height at {} years by the curve of {} ({}), with the mean "
                  "age of the trees of a plot",
                  curve.base_age,
                  curve.title,
                  curve.id));
  const auto map = tree::SpeciesMap::load(options.equations.models);
  note_other_species(trees, curve, map, summary.report.notes);
  if (outside == 0) return;
  summary.report.notes.push_back(
      fmt::format("{} outside the ages of the curve, {} to {} years, and without a site index",
                  counted(outside, "plot is", "plots are"),
                  curve.lowest_age,
                  curve.highest_age));
}

}  // namespace

void refuse_idle(const StandOptions& options, const GivenName& given_name) {
  refuse_idle(options, idle_in_stand(options, false), given_name);
}

void refuse_idle_on_growth(const StandOptions& options, const GivenName& given_name) {
  IdleReasons idle = idle_in_stand(options, true);
  for (const std::string_view key : kIdleOnGrowth) idle[key] = "on growth";
  if (options.report.plot_area_m2) {
    for (const char* key : {"window", "circle"}) idle[key] = "beside `plot_area`";
  }
  refuse_idle(options, idle, given_name);
}

StandSummary stand_summary(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks,
                           const StandUnitSink& sink) {
  refuse_idle(options);
  const auto start = Clock::now();
  if (options.stream && (!options.thinning.empty() || !options.site_index.empty())) {
    throw UsageError("a thinning and site indices need all trees in memory; omit `stream`",
                     {.column = "`stream`"});
  }
  const stand::StandReportOptions report = report_options(options);
  StandSummary summary{.settings = options.units};
  stand::InventoryBatches flow = inventory_flow(
      inventory,
      options.reading,
      {.keep = columns_of(options),
       .refuses_unread = true,
       .has_expansion = !options.sampling.expansion.empty(),
       .keeps_expansion = !options.stream},
      {.is_in_parts = options.stream, .rows = kRowsOfBatch, .threads = options.threads},
      callbacks.note);
  QuantitiesOfParts quantities(options.equations);
  const auto add_quantities = [&](stand::Inventory& trees) {
    if (!options.equations.equations.empty()) {
      trees.quantities = quantities.add(stand::to_table(trees));
    }
    add_totals(options, trees);
  };
  if (options.stream) {
    add_parts(flow, report, add_quantities, callbacks, sink, summary);
  } else {
    summary.inventory = std::move(*flow.next());
    add_quantities(summary.inventory.inventory);
    summary.report = stand::stand_report(summary.inventory.inventory, report);
    if (sink && summary.report.units) sink(summary.inventory, *summary.report.units);
    add_thinning(options, report, summary);
    add_site_indices(options, summary);
  }
  for (std::string& note : notes_on_totals(summary.report)) {
    summary.report.notes.push_back(std::move(note));
  }
  summary.notes = complete_notes(
      report, quantities.notes(), summary.inventory.notes, summary.report.notes, callbacks);
  summary.seconds = seconds_since(start);
  return summary;
}

std::vector<std::pair<std::string, data::Table>> tables_of(const StandSummary& summary) {
  auto tables = stand::tables_of(summary.report);
  if (summary.thinning) {
    std::vector<stand::ThinningFigures> plots = summary.thinning->plots;
    plots.push_back(summary.thinning->all);
    plots.back().name = "all";
    data::ListTable<stand::ThinningFigures> table(plots);
    table.add("plot", &stand::ThinningFigures::name);
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
        table.add(fmt::format("{}_{}", value, stage),
                  [figure = figures, member = member](const stand::ThinningFigures& plot) {
                    return plot.*figure.*member;
                  });
      }
    }
    tables.emplace_back("thinning", std::move(table).table());
    data::Table trees = stand::to_table(summary.inventory.inventory);
    const std::vector<char>& removed = summary.thinning->is_removed;
    trees.set("removed", std::vector<double>(removed.begin(), removed.end()));
    tables.emplace_back("trees", std::move(trees));
  }
  if (!summary.sites.empty()) {
    data::ListTable<SiteIndex> table(summary.sites);
    table.add("plot", &SiteIndex::plot);
    table.add("age", &SiteIndex::age);
    table.add("dominant_height_m", &SiteIndex::dominant_m);
    table.add("site_index_m", &SiteIndex::at_base_age);
    tables.emplace_back("sites", std::move(table).table());
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
    throw UsageError("a report needs all trees in memory; omit `stream`", {.column = "`stream`"});
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
  record.thinning = std::move(summary.thinning);
  record.sites = std::move(summary.sites);
  const std::string title =
      "silvafit: " + std::filesystem::path(record.inventory.inventory.file).filename().string();
  write_report_page(page_template, report_data(record, catalogue), title, file);
}

nlohmann::ordered_json json_of(const StandSummary& summary) {
  const nlohmann::ordered_json words = settings_json(summary.settings);
  nlohmann::ordered_json result{{"schema", "silvafit-stand/1"},
                                {"silvafit", SILVAFIT_VERSION},
                                {"inventory", summary.inventory.inventory.file},
                                {"excluded", summary.inventory.excluded_tree_count},
                                {"edge", words["edge"]},
                                {"per", words["per"]}};
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

GrowthSummary stand_growth(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks) {
  refuse_idle_on_growth(options);
  const auto start = Clock::now();
  const stand::StandReportOptions report = report_options(options);
  const stand::InventoryOptions reading{.keep = columns_of(options),
                                        .refuses_unread = true,
                                        .has_expansion = !options.sampling.expansion.empty(),
                                        .keeps_expansion = true,
                                        .keeps_measurements = true,
                                        .subplot = options.sampling.subplot};
  GrowthSummary summary{.inventory =
                            read_inventory(inventory, options.reading, reading, callbacks.note)};
  stand::Inventory& trees = summary.inventory.inventory;
  QuantitiesOfParts quantities(options.equations);
  if (!options.equations.equations.empty()) {
    trees.quantities = quantities.add(stand::to_table(trees));
  }
  add_totals(options, trees);
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
