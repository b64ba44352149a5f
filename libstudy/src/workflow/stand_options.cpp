// SPDX-License-Identifier: MIT
#include "workflow/stand_options.hpp"

#include <utility>

#include "silvafit/base/error.hpp"

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
  return columns;
}

std::vector<std::string> add_quantities(const StandOptions& options, stand::Inventory& inventory) {
  if (options.equations.equations.empty()) return {};
  TreeQuantities found = tree_quantities(stand::to_table(inventory), options.equations);
  inventory.quantities = std::move(found.quantities);
  return std::move(found.notes);
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
