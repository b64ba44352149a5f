// SPDX-License-Identifier: MIT
#include "silvafit/study/study_configuration.hpp"

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/variance_function.hpp"
#include "study/unit_settings_json.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;

/// Converts a text by a function that may throw; the error names the key.
template <typename Read>
auto checked(const JsonReader& json, Read read) {
  try {
    return read(json.text());
  } catch (const UsageError& error) {
    json.fail(error.what());
  }
}

void read_candidates(const JsonReader& json, const Catalogue* catalogue, StudyOptions& options) {
  for (const auto& [response, list] : json.members_by_name()) {
    for (const JsonReader& item : list.items()) {
      const std::string text = checked(item, [catalogue](const std::string& candidate) {
        if (candidate.find('~') != std::string::npos) {
          data::parse_formula(candidate);
        } else if (catalogue != nullptr) {
          catalogue->find(candidate);
        }
        return candidate;
      });
      options.candidates[response].push_back(text);
    }
    if (options.candidates[response].empty()) list.fail("has no candidate");
  }
}

/// One criterion for all levels, or one for each level.
void read_criteria(const JsonReader& json, LevelCriteria& criteria) {
  if (!json.is_object()) {
    const Criterion all = checked(json, parse_criterion);
    criteria = {.base = all, .covariates = all, .random = all, .variance = all};
    return;
  }
  json.allow_only({"base", "covariates", "random", "variance"});
  const auto read = [&](std::string_view key, Criterion& criterion) {
    if (const auto found = json.find(key)) criterion = checked(*found, parse_criterion);
  };
  read("base", criteria.base);
  read("covariates", criteria.covariates);
  read("random", criteria.random);
  read("variance", criteria.variance);
}

/// The name of a column, or null for none.
void read_column(const JsonReader& json, std::string_view key, std::string& column) {
  if (const auto value = json.find(key); value && !value->is_null()) column = value->text();
}

void read_variance_functions(const JsonReader& json, StudyOptions& options) {
  options.variance_functions.clear();
  for (const JsonReader& item : json.items()) {
    options.variance_functions.push_back(checked(
        item, [](const std::string& text) { return fit::parse_variance_function(text).text(); }));
  }
}

void read_search(const JsonReader& json, const Catalogue* catalogue, StudyOptions& options) {
  if (const auto list = json.find("species")) options.species = list->texts();
  if (const auto list = json.find("responses")) options.responses = list->texts();
  if (const auto list = json.find("candidates")) read_candidates(*list, catalogue, options);
  if (const auto list = json.find("covariates")) options.covariates = list->texts();
  if (const auto value = json.find("covariate_parameters")) {
    options.covariate_parameters = static_cast<std::size_t>(value->number_between(1, 2));
  }
  if (const auto value = json.find("group")) options.group = value->text();
  read_column(json, "period", options.period);
  if (const auto value = json.find("maximum_random_effects")) {
    options.maximum_random_effects = value->count();
  }
  if (const auto list = json.find("variance_functions")) read_variance_functions(*list, options);
}

void read_choice(const JsonReader& json, StudyOptions& options) {
  if (const auto criteria = json.find("criteria")) read_criteria(*criteria, options.criteria);
  if (const auto value = json.find("choice")) {
    options.parsimonious = value->one_of({"best", "parsimonious"}) == 1;
  }
  if (const auto value = json.find("equally_good")) options.equally_good = value->not_negative();
  if (const auto value = json.find("tests")) {
    options.needs_tests = value->one_of({"required", "shown"}) == 0;
  }
  if (const auto value = json.find("significance")) {
    options.significance = value->number_between(0.0, 1.0);
  }
  if (const auto value = json.find("minimum_trees")) options.minimum_trees = value->count();
  if (const auto value = json.find("compared_trees")) {
    options.compared_trees = static_cast<std::size_t>(value->count_or_zero());
  }
}

ReadingSettings read_reading_settings(const JsonReader& json) {
  ReadingSettings settings;
  if (const auto columns = json.find("columns")) {
    for (const auto& [name, source] : columns->members_by_name()) {
      settings.columns.push_back(name + "=" + source.text());
    }
  }
  if (const auto value = json.find("trust_units")) settings.trust_units = value->boolean();
  if (const auto list = json.find("missing")) settings.missing = list->texts();
  if (const auto list = json.find("fill_down")) settings.fill_down = list->texts();
  if (const auto value = json.find("dead")) {
    value->one_of({"leave-out", "neighbors", "include"});
    settings.dead = value->text();
  }
  if (const auto list = json.find("alive_codes")) settings.alive_codes = list->texts();
  if (const auto list = json.find("dead_codes")) settings.dead_codes = list->texts();
  if (const auto list = json.find("cut_codes")) settings.cut_codes = list->texts();
  if (const auto value = json.find("case_sensitive")) settings.case_sensitive = value->boolean();
  return settings;
}

/// The keys of structural units that are not in model libraries.
void read_edge(const JsonReader& json, const std::filesystem::path& folder, UnitSettings& units) {
  if (const auto value = json.find("window"); value && !value->is_null()) {
    units.window = (folder / value->text()).string();
  }
  if (const auto value = json.find("edge")) {
    value->one_of({"buffer", "hanisch", "torus", "none"});
    units.edge = value->text();
  }
  if (const auto value = json.find("buffer")) units.buffer_m = value->not_negative();
  if (const auto value = json.find("circle"); value && !value->is_null()) {
    units.circle = value->text();
    if (!units.window.empty()) value->fail("give either a circle or a window");
  }
  if (const auto list = json.find("further")) units.further = list->texts();
}

SamplingSettings read_sampling(const JsonReader& json, const std::filesystem::path& folder) {
  SamplingSettings settings;
  if (const auto value = json.find("plots"); value && !value->is_null()) {
    settings.plots_file = (folder / value->text()).string();
  }
  if (const auto columns = json.find("plots_columns")) {
    for (const auto& [name, source] : columns->members_by_name()) {
      settings.plots_columns.push_back(name + "=" + source.text());
    }
  }
  if (const auto list = json.find("circles")) settings.circles = list->texts();
  if (const auto value = json.find("angle_count")) settings.angle_count = value->not_negative();
  if (const auto value = json.find("smallest_dbh")) {
    settings.smallest_dbh_cm = value->not_negative();
  }
  read_column(json, "expansion", settings.expansion);
  if (const auto value = json.find("expansion_area")) {
    value->one_of({"plot", "part"});
    settings.expansion_area = value->text();
  }
  if (const auto value = json.find("subplots")) settings.subplots = value->count();
  read_column(json, "subplot", settings.subplot);
  if (const auto value = json.find("slope_correction")) {
    settings.slope_correction = value->boolean();
  }
  return settings;
}

/// The settings of a document: all of a study.json, a part of a run.json.
JsonReader settings_of(const JsonReader& json) {
  const auto schema = json.find("schema");
  if (!schema) return json;
  schema->one_of({"silvafit-run/1"});
  return json.at("options");
}

}  // namespace

StudyConfiguration read_study_configuration(const std::filesystem::path& path,
                                            const Catalogue* catalogue) {
  const JsonReader json = settings_of(JsonReader::parse(read_file(path), path.string(), true));
  json.allow_only({"species",
                   "minimum_trees",
                   "responses",
                   "candidates",
                   "covariates",
                   "covariate_parameters",
                   "group",
                   "period",
                   "maximum_random_effects",
                   "variance_functions",
                   "criteria",
                   "choice",
                   "equally_good",
                   "tests",
                   "significance",
                   "compared_trees",
                   "columns",
                   "window",
                   "edge",
                   "buffer",
                   "per",
                   "neighbors",
                   "trust_units",
                   "missing",
                   "fill_down",
                   "dead",
                   "alive_codes",
                   "dead_codes",
                   "cut_codes",
                   "case_sensitive",
                   "circle",
                   "alpha",
                   "dominance",
                   "crowding",
                   "further",
                   "competition_radius",
                   "open_grown",
                   "plots",
                   "plots_columns",
                   "circles",
                   "angle_count",
                   "smallest_dbh",
                   "expansion",
                   "expansion_area",
                   "subplots",
                   "subplot",
                   "slope_correction"});
  StudyConfiguration configuration;
  read_search(json, catalogue, configuration.study);
  read_choice(json, configuration.study);
  configuration.reading = read_reading_settings(json);
  configuration.units = read_unit_settings(json);
  read_edge(json, path.parent_path(), configuration.units);
  configuration.sampling = read_sampling(json, path.parent_path());
  return configuration;
}

StudyConfiguration seen_from(const std::filesystem::path& folder, StudyConfiguration settings) {
  const std::filesystem::path from = followed(folder.empty() ? "." : folder);
  for (std::string* const file : {&settings.units.window, &settings.sampling.plots_file}) {
    if (file->empty() || std::filesystem::path(*file).is_absolute()) continue;
    *file = followed(*file).lexically_proximate(from).string();
  }
  return settings;
}

}  // namespace silvafit::study
