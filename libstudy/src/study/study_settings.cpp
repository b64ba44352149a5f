// SPDX-License-Identifier: MIT
#include "study/study_settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "silvafit/base/json_values.hpp"
#include "study/unit_settings_json.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

ordered_json columns_json(const std::vector<std::string>& columns) {
  ordered_json json = ordered_json::object();
  const std::string entries = fmt::format("{}", fmt::join(columns, ","));
  for (const stand::ColumnMapping& column : stand::parse_column_mappings(entries)) {
    json[column.name] = column.source;
  }
  return json;
}

ordered_json search_json(const StudyOptions& options) {
  return {{"species", options.species},
          {"minimum_trees", options.minimum_trees},
          {"responses", options.responses},
          {"candidates", options.candidates},
          {"covariates", options.covariates},
          {"covariate_parameters", options.covariate_parameters},
          {"group", options.group},
          {"period", text_or_null(options.period)},
          {"maximum_random_effects", options.maximum_random_effects},
          {"variance_functions", options.variance_functions},
          {"criteria",
           {{"base", criterion_text(options.criteria.base)},
            {"covariates", criterion_text(options.criteria.covariates)},
            {"random", criterion_text(options.criteria.random)},
            {"variance", criterion_text(options.criteria.variance)}}},
          {"choice", options.parsimonious ? "parsimonious" : "best"},
          {"equally_good", options.equally_good},
          {"tests", options.needs_tests ? "required" : "shown"},
          {"significance", options.significance},
          {"compared_trees", options.compared_trees}};
}

ordered_json sampling_json(const SamplingSettings& settings) {
  return {{"plots", text_or_null(settings.plots_file)},
          {"plots_columns", columns_json(settings.plots_columns)},
          {"circles", settings.circles},
          {"angle_count", settings.angle_count},
          {"smallest_dbh", settings.smallest_dbh_cm},
          {"expansion", text_or_null(settings.expansion)},
          {"expansion_area", settings.expansion_area},
          {"subplots", settings.subplots},
          {"subplot", text_or_null(settings.subplot)},
          {"slope_correction", settings.slope_correction}};
}

}  // namespace

ordered_json settings_json(const StudyConfiguration& settings) {
  ordered_json json = search_json(settings.study);
  const ReadingSettings& reading = settings.reading;
  json["columns"] = columns_json(reading.columns);
  json["trust_units"] = reading.trust_units;
  json["missing"] = reading.missing;
  json["fill_down"] = reading.fill_down;
  json["dead"] = reading.dead;
  json["alive_codes"] = reading.alive_codes;
  json["dead_codes"] = reading.dead_codes;
  json["cut_codes"] = reading.cut_codes;
  json["case_sensitive"] = reading.case_sensitive;
  json["window"] = text_or_null(settings.units.window);
  json["circle"] = text_or_null(settings.units.circle);
  json["edge"] = settings.units.edge;
  json["buffer"] = settings.units.buffer_m;
  json["further"] = settings.units.further;
  json.update(unit_settings_json(settings.units));
  json.update(sampling_json(settings.sampling));
  return json;
}

}  // namespace silvafit::study
