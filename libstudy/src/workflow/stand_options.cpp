// SPDX-License-Identifier: MIT
#include "workflow/stand_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/stand_growth.hpp"

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

stand::StandReportOptions report_options(const StandOptions& options) {
  stand::StandReportOptions report = options.report;
  report.units = unit_options(options.units, options.threads);
  report.design = sampling_design(options.sampling);
  report.trust_units = options.reading.trust_units;
  refuse_idle_settings(options, {}, idle_without_strata(report));
  return report;
}

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

void add_totals(const std::vector<std::string>& columns, stand::Inventory& inventory) {
  for (const std::string& column : columns) {
    const bool is_other = inventory.other.has(column);
    const data::Table table = is_other ? data::Table() : stand::to_table(inventory);
    const data::Table& source = is_other ? inventory.other : table;
    if (!source.has(column) || !source.is_numeric(column)) {
      throw InputError(source.has(column) ? fmt::format("'{}' is not a column of numbers", column)
                                          : data::no_such_column(column, source.names()),
                       {.file = inventory.file, .column = "`totals`"});
    }
    const auto values = source.numbers(column);
    inventory.quantities.push_back({.name = column, .values = {values.begin(), values.end()}});
  }
}

std::vector<std::string> notes_on_totals(const StandOptions& options,
                                         const stand::StandReport& report) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < report.quantities.size(); ++i) {
    const bool is_column =
        std::ranges::find(options.totals, report.quantities[i]) != options.totals.end();
    const std::size_t without = report.all.trees_without_quantity[i];
    if (!is_column || without == 0) continue;
    notes.push_back(
        fmt::format("{} no {}; sums do not include {}, and means are those of the others",
                    counted(without, "tree has", "trees have"),
                    report.quantities[i],
                    without == 1 ? "it" : "them"));
  }
  return notes;
}

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

}  // namespace silvafit::study
