// SPDX-License-Identifier: MIT
#include "workflow/stand_options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"

namespace silvafit::study {
namespace {

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

}  // namespace

stand::StandReportOptions report_options(const StandOptions& options) {
  stand::StandReportOptions report = options.report;
  report.units = unit_options(options.units, options.threads);
  report.design = sampling_design(options.sampling);
  report.trust_units = options.reading.trust_units;
  check_stratum_areas(report);
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
