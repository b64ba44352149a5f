// SPDX-License-Identifier: MIT
#include "study/study_settings.hpp"

#include "study/unit_settings_json.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

ordered_json columns_json(const std::vector<std::string>& columns) {
  ordered_json json = ordered_json::object();
  for (const std::string& column : columns) {
    const std::size_t sign = column.find('=');
    json[column.substr(0, sign)] = column.substr(sign + 1);
  }
  return json;
}

ordered_json text_or_null(const std::optional<std::string>& text) {
  return text && !text->empty() ? ordered_json(*text) : ordered_json(nullptr);
}

ordered_json search_json(const StudyOptions& options) {
  return {{"species", options.species},
          {"minimum_trees", options.minimum_trees},
          {"responses", options.responses},
          {"candidates", options.candidates},
          {"covariates", options.covariates},
          {"covariate_parameters", options.covariate_parameters},
          {"group", options.group},
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

}  // namespace

ordered_json settings_json(const StudyConfiguration& settings) {
  ordered_json json = search_json(settings.study);
  json["columns"] = columns_json(settings.columns);
  json["trust_units"] = settings.trust_units.value_or(false);
  json["missing"] = settings.missing;
  json["fill_down"] = settings.fill_down;
  json["dead"] = settings.dead.value_or("leave-out");
  json["case_sensitive"] = settings.case_sensitive.value_or(false);
  json["window"] = text_or_null(settings.window);
  json["circle"] = text_or_null(settings.circle);
  json["edge"] = settings.edge.value_or("buffer");
  json["buffer"] = settings.buffer_m.value_or(5.0);
  json["further"] = settings.further.value_or(std::vector<std::string>{});
  json.update(unit_settings_json(settings.units));
  return json;
}

}  // namespace silvafit::study
