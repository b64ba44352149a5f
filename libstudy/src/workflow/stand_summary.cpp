// SPDX-License-Identifier: MIT
#include "silvafit/study/stand_summary.hpp"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "silvafit/base/error.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/indices.hpp"

namespace silvafit::study {
namespace {

void add_stratum_areas(const std::vector<std::string>& areas, stand::StandReportOptions& options) {
  for (const std::string& part : areas) {
    const std::size_t sign = part.rfind('=');
    double hectares = 0.0;
    const bool is_pair = sign != std::string::npos &&
                         data::parse_number(std::string_view(part).substr(sign + 1), hectares);
    if (!is_pair) {
      throw UsageError(fmt::format("'{}' is not STRATUM=HECTARES, such as A=120", part),
                       {.column = "--stratum-area"});
    }
    options.stratum_areas_ha[part.substr(0, sign)] = hectares;
  }
  if (!options.stratum_areas_ha.empty() && options.stratum.empty()) {
    throw UsageError("--stratum-area needs --stratum, the column of the strata",
                     {.column = "--stratum-area"});
  }
}

}  // namespace

StandSummary stand_summary(const data::TableSource& inventory,
                           const StandOptions& options,
                           const Callbacks& callbacks) {
  const auto start = std::chrono::steady_clock::now();
  stand::StandReportOptions report = options.report;
  report.units = unit_options(options.units, options.threads);
  add_stratum_areas(options.stratum_areas, report);
  stand::InventoryOptions reading;
  if (!report.stratum.empty()) reading.keep = {report.stratum};
  StandSummary summary{
      .settings = options.units,
      .inventory = read_inventory(inventory, options.reading, reading, callbacks.note)};
  summary.report = stand::stand_report(summary.inventory.inventory, report);
  give_notes(summary.report.notes, callbacks.note);
  summary.notes = summary.inventory.notes;
  summary.notes.insert(
      summary.notes.end(), summary.report.notes.begin(), summary.report.notes.end());
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
