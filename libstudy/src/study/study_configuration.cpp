// SPDX-License-Identifier: MIT
#include "silvafit/study/study_configuration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/variance_function.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;
using nlohmann::ordered_json;

/// The value of a reader that may find a text it does not know; the complaint names the key.
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
    if (options.candidates[response].empty()) list.fail("names no candidate");
  }
}

/// One criterion for all levels, or one a level.
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
}

void read_inventory_keys(const JsonReader& json,
                         const std::filesystem::path& folder,
                         StudyConfiguration& configuration) {
  if (const auto columns = json.find("columns")) {
    for (const auto& [name, source] : columns->members_by_name()) {
      configuration.columns.push_back(name + "=" + source.text());
    }
  }
  if (const auto value = json.find("window"); value && !value->is_null()) {
    configuration.window = (folder / value->text()).string();
  }
  if (const auto value = json.find("edge")) {
    value->one_of({"buffer", "hanisch", "torus", "none"});
    configuration.edge = value->text();
  }
  if (const auto value = json.find("buffer")) configuration.buffer_m = value->not_negative();
  if (const auto value = json.find("per")) {
    value->one_of({"plot", "stand"});
    configuration.per = value->text();
  }
  if (const auto value = json.find("neighbors")) configuration.neighbors = value->count();
}

/// Lines of JSON that each end in a comment.
class CommentedJson {
 public:
  void comment(const std::string& text) { text_ += "  // " + text + "\n"; }
  void blank() { text_ += "\n"; }
  void add(const std::string& key, const ordered_json& value, const std::string& note = "") {
    text_ += fmt::format("  \"{}\": {},", key, json_text(value));
    if (!note.empty()) text_ += "  // " + note;
    text_ += "\n";
  }
  void add_object(const std::string& key, const std::vector<std::string>& lines) {
    text_ += fmt::format("  \"{}\": {{\n", key);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      text_ += fmt::format("    {}\n", lines[i]);
    }
    text_ += "  },\n";
  }
  /// The last entry, which no comma follows.
  std::string finish(const std::string& key, const ordered_json& value, const std::string& note) {
    text_ += fmt::format("  \"{}\": {}  // {}\n", key, json_text(value), note);
    return "{\n" + text_ + "}\n";
  }

 private:
  std::string text_;
};

std::string species_note(const data::Table& table) {
  const data::TextColumn species = table.labels("species");
  std::map<std::string, std::size_t> counts;
  for (std::size_t row = 0; row < species.size(); ++row) {
    if (!species.is_missing(row)) ++counts[std::string(species[row])];
  }
  std::vector<std::string> texts;
  for (const auto& [name, count] : counts) texts.push_back(fmt::format("{} ({})", name, count));
  return fmt::format("trees in the file: {}", fmt::join(texts, ", "));
}

std::vector<std::string> candidate_lines(const std::vector<std::string>& responses,
                                         const Catalogue& catalogue) {
  std::vector<std::string> lines;
  for (std::size_t r = 0; r < responses.size(); ++r) {
    const std::vector<const BaseModel*> models = catalogue.candidates(responses[r]);
    lines.push_back(fmt::format("\"{}\": [", responses[r]));
    for (std::size_t i = 0; i < models.size(); ++i) {
      lines.push_back(fmt::format("  \"{}\"{}  // {}: {}",
                                  models[i]->id,
                                  i + 1 < models.size() ? "," : "",
                                  models[i]->name,
                                  models[i]->formula));
    }
    lines.push_back(r + 1 < responses.size() ? "]," : "]");
  }
  return lines;
}

/// Numeric columns that are not measures of the tree itself.
std::vector<std::string> possible_covariates(const data::Table& table) {
  const std::vector<std::string> own{"plot",
                                     "tree",
                                     "x",
                                     "y",
                                     "z",
                                     "dbh",
                                     "h",
                                     "hcb",
                                     "cw",
                                     "core",
                                     "cr_e",
                                     "cr_w",
                                     "cr_s",
                                     "cr_n",
                                     "weight"};
  std::vector<std::string> names;
  for (const std::string& name : table.names()) {
    if (table.is_numeric(name) && std::ranges::find(own, name) == own.end()) names.push_back(name);
  }
  return names;
}

void describe_models(const data::Table& table, const Catalogue& catalogue, CommentedJson& json) {
  const StudyOptions defaults;
  std::vector<std::string> responses;
  std::ranges::copy_if(defaults.responses,
                       std::back_inserter(responses),
                       [&](const std::string& name) { return table.has(name); });
  json.comment("Species to study; an empty list: all with enough trees.");
  json.add("species", ordered_json::array(), species_note(table));
  json.add("minimum_trees", defaults.minimum_trees, "fewest measured trees that get models");
  json.blank();
  json.comment(
      "What to model, and by which equations: entries of the catalogue (`silvafit models`), or");
  json.comment(
      "formulas of your own such as \"h ~ 1.3 + a*dbh^b\". A response without a list has all "
      "entries.");
  json.add("responses", responses);
  json.add_object("candidates", candidate_lines(responses, catalogue));
  json.blank();
  json.comment(
      "Covariates of the parameters: structural indices (W, M, U, C, CO, T, Hegyi, BAL, CCF), "
      "figures of the");
  json.comment(
      "plot (stems_per_ha, basal_area_per_ha, quadratic_mean_dbh, dominant_height), or columns of "
      "the file.");
  const std::vector<std::string> columns = possible_covariates(table);
  json.add("covariates",
           defaults.covariates,
           columns.empty() ? "" : fmt::format("columns of the file: {}", fmt::join(columns, ", ")));
  json.add("covariate_parameters",
           defaults.covariate_parameters,
           "parameters that may have covariates at once: 1 or 2");
  json.blank();
  json.comment("Random effects of the groups of a column, on so many coefficients at most.");
  json.add("group", defaults.group);
  json.add("maximum_random_effects", defaults.maximum_random_effects);
  json.add("variance_functions", defaults.variance_functions);
}

void describe_choice(CommentedJson& json) {
  const StudyOptions defaults;
  const LevelCriteria& criteria = defaults.criteria;
  json.blank();
  json.comment(
      "How models are chosen at each level: aic, aicc, bic, or cv (error of predictions for plots "
      "left out).");
  json.add("criteria",
           {{"base", criterion_text(criteria.base)},
            {"covariates", criterion_text(criteria.covariates)},
            {"random", criterion_text(criteria.random)},
            {"variance", criterion_text(criteria.variance)}});
  json.add("choice",
           "best",
           "of random effects and variance functions: best, or parsimonious within equally_good");
  json.add("equally_good", defaults.equally_good, "distance of the criterion that does not count");
  json.add("tests",
           "required",
           "likelihood-ratio tests must be significant (required), or are shown only");
  json.add("significance", defaults.significance, "of the tests");
}

std::string describe_inventory(CommentedJson& json) {
  json.blank();
  json.comment("The inventory and its structural units, as the options of the same names.");
  json.add("columns",
           ordered_json::object(),
           "where columns come from, such as {\"dbh\": \"DBH_cm\", \"x\": \"xk/10\"}");
  json.add("window", nullptr, "boundary of the plots: a GeoJSON, WKT or CSV file");
  json.add("edge", "buffer", "buffer, hanisch, torus or none");
  json.add("buffer", 5.0, "meters");
  json.add("per", "plot", "neighbors in the plot, or in the whole stand");
  return json.finish("neighbors", 4, "of a structural unit");
}

}  // namespace

StudyConfiguration read_study_configuration(const std::filesystem::path& path,
                                            const Catalogue* catalogue) {
  const JsonReader json = JsonReader::parse(read_file(path), path.string(), true);
  json.allow_only({"species",
                   "minimum_trees",
                   "responses",
                   "candidates",
                   "covariates",
                   "covariate_parameters",
                   "group",
                   "maximum_random_effects",
                   "variance_functions",
                   "criteria",
                   "choice",
                   "equally_good",
                   "tests",
                   "significance",
                   "columns",
                   "window",
                   "edge",
                   "buffer",
                   "per",
                   "neighbors"});
  StudyConfiguration configuration;
  for (const auto& [key, value] : json.members_by_name()) configuration.mentioned.push_back(key);
  read_search(json, catalogue, configuration.study);
  read_choice(json, configuration.study);
  read_inventory_keys(json, path.parent_path(), configuration);
  return configuration;
}

std::string study_configuration_for(const data::Table& table, const Catalogue& catalogue) {
  CommentedJson json;
  describe_models(table, catalogue, json);
  describe_choice(json);
  return describe_inventory(json);
}

}  // namespace silvafit::study
