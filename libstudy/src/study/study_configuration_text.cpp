// SPDX-License-Identifier: MIT
// Writes a study.json with every key, its value, and comments.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/study_configuration.hpp"
#include "study/study_settings.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

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
  /// The last entry, without a comma.
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
  texts.reserve(counts.size());
  for (const auto& [name, count] : counts) texts.push_back(fmt::format("{} ({})", name, count));
  return fmt::format("trees in the file: {}", fmt::join(texts, ", "));
}

/// The candidates of a response, each with its name and formula in the catalogue.
std::vector<std::string> candidate_lines(const std::vector<std::string>& candidates,
                                         const Catalogue& catalogue) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    std::string line = fmt::format(
        "  {}{}", json_text(ordered_json(candidates[i])), i + 1 < candidates.size() ? "," : "");
    if (candidates[i].find('~') == std::string::npos) {
      const BaseModel& model = catalogue.find(candidates[i]);
      line += fmt::format("  // {}: {}", model.name, model.formula);
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

/// The candidates of all responses: those that were named, else those of the catalogue.
std::vector<std::string> candidate_lines(const std::vector<std::string>& responses,
                                         std::map<std::string, std::vector<std::string>> candidates,
                                         const Catalogue& catalogue) {
  for (const std::string& response : responses) {
    if (candidates.contains(response)) continue;
    for (const BaseModel* model : catalogue.candidates(response)) {
      candidates[response].push_back(model->id);
    }
  }
  std::vector<std::string> order;
  std::ranges::copy_if(responses, std::back_inserter(order), [&](const std::string& response) {
    return candidates.contains(response);
  });
  for (const auto& [response, list] : candidates) {
    if (std::ranges::find(order, response) == order.end()) order.push_back(response);
  }
  std::vector<std::string> lines;
  for (const std::string& response : order) {
    lines.push_back(fmt::format("{}: [", json_text(ordered_json(response))));
    for (std::string& line : candidate_lines(candidates.at(response), catalogue)) {
      lines.push_back(std::move(line));
    }
    lines.emplace_back(response == order.back() ? "]" : "],");
  }
  return lines;
}

/// Columns of the file from which other columns are computed.
std::set<std::string> mapped_sources(const std::vector<std::string>& columns) {
  std::set<std::string> sources;
  const std::string text = fmt::format("{}", fmt::join(columns, ","));
  for (const stand::ColumnMapping& mapping : stand::parse_column_mappings(text)) {
    sources.insert(mapping.source);
    try {
      const data::Expression expression = data::Expression::parse(mapping.source);
      for (const std::string& name : expression.variables()) sources.insert(name);
    } catch (const FormulaError&) {
      // The name of a column such as `BHD [cm]` need not be an expression.
    }
  }
  return sources;
}

/// Numeric columns that are neither measures of the tree itself nor sources of them.
std::vector<std::string> possible_covariates(const data::Table& table,
                                             const std::vector<std::string>& columns) {
  const std::set<std::string> sources = mapped_sources(columns);
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
    const bool is_used = std::ranges::find(own, name) != own.end() || sources.contains(name);
    if (table.is_numeric(name) && !is_used) names.push_back(name);
  }
  return names;
}

/// The responses to model; of the usual ones those in the inventory.
std::vector<std::string> responses_for(const data::Table& table, const StudyOptions& options) {
  std::vector<std::string> responses = options.responses;
  if (responses == StudyOptions{}.responses) {
    std::erase_if(responses, [&](const std::string& name) { return !table.has(name); });
  }
  return responses;
}

void describe_models(const data::Table& table,
                     const Catalogue& catalogue,
                     const StudyConfiguration& settings,
                     const ordered_json& values,
                     CommentedJson& json) {
  const std::vector<std::string> responses = responses_for(table, settings.study);
  json.comment("Species to study; an empty list: all with enough trees.");
  json.add("species", values.at("species"), species_note(table));
  json.add(
      "minimum_trees", values.at("minimum_trees"), "minimum number of measured trees of a species");
  json.blank();
  json.comment("Responses and their equations: entries of the catalogue (`silvafit models`), or");
  json.comment(
      "formulas of your own such as \"h ~ 1.3 + a*dbh^b\". Without a list, all entries are tried.");
  json.add("responses", responses);
  json.add_object("candidates", candidate_lines(responses, settings.study.candidates, catalogue));
  json.blank();
  json.comment(
      "Covariates of the parameters: structural indices (W, M, U, C, CO, T, Hegyi, BAL, CCF), "
      "figures of the");
  json.comment(
      "plot (stems_per_ha, basal_area_per_ha, quadratic_mean_dbh, dominant_height), or columns of "
      "the file.");
  const std::vector<std::string> columns = possible_covariates(table, settings.reading.columns);
  json.add("covariates",
           values.at("covariates"),
           columns.empty() ? "" : fmt::format("columns of the file: {}", fmt::join(columns, ", ")));
  json.add("covariate_parameters",
           values.at("covariate_parameters"),
           "number of parameters that may have covariates: 1 or 2");
  json.blank();
  json.comment("Random effects by the groups of a column, on at most this many coefficients.");
  json.add("group", values.at("group"));
  json.add("period",
           values.at("period"),
           "column of the times of repeated measurements, as periods within the groups");
  json.add("maximum_random_effects", values.at("maximum_random_effects"));
  json.add("variance_functions", values.at("variance_functions"));
}

void describe_choice(const ordered_json& values, CommentedJson& json) {
  json.blank();
  json.comment(
      "Criterion at each level: aic, aicc, bic, or cv (prediction error for plots left out).");
  json.add("criteria", values.at("criteria"));
  json.add("choice",
           values.at("choice"),
           "of random effects and variance functions: best, or parsimonious within equally_good");
  json.add("equally_good",
           values.at("equally_good"),
           "difference of the criterion within which models are equally good");
  json.add("tests",
           values.at("tests"),
           "likelihood-ratio tests: required (must be significant) or shown");
  json.add("significance", values.at("significance"), "level of the tests");
  json.add("compared_trees",
           values.at("compared_trees"),
           "maximum number of trees of a species for comparing candidates; 0: all");
}

std::string describe_inventory(const ordered_json& values, CommentedJson& json) {
  json.blank();
  json.comment("The inventory and its structural units; see the options of the same names.");
  const auto add = [&](const char* key, const char* note) { json.add(key, values.at(key), note); };
  add("columns", "where columns come from, such as {\"dbh\": \"DBH_cm\", \"x\": \"xk/10\"}");
  add("trust_units", "accept the units of the columns without a check");
  add("missing", "further texts and numbers for missing values, such as [\"-88\"]");
  add("fill_down", "columns whose empty fields have the value above, such as [\"plot\"]");
  add("dead", "dead trees: leave-out, neighbors or include");
  add("alive_codes", "values of the status column that mean alive, such as [\"LI\"]");
  add("dead_codes", "values that mean dead and standing, such as [\"DS\"]");
  add("cut_codes", "values that mean cut or fallen, such as [\"DC\"]");
  add("case_sensitive", "species that differ only in capitals are different");
  add("window", "boundary of the plots: a GeoJSON, WKT or CSV file");
  add("circle", "circle that is the boundary of every plot, instead of a window: \"0,0,12.62\"");
  add("edge", "buffer, hanisch, torus or none");
  add("buffer", "meters");
  add("per", "search neighbors in the plot or in the whole stand");
  add("neighbors", "neighbors of a structural unit");
  add("alpha", "limit angles of W in degrees, such as [\"72\", \"SM=60\"]");
  add("dominance", "size that U and T compare: dbh, h or cw");
  add("crowding", "crowns in C: mean or facing");
  add("further", "indices: CO, T, Hegyi, BAL, CCF or all");
  add("competition_radius", "of Hegyi's index in meters; 0: the neighbors");
  add("open_grown", "for CCF: crown width of an open-grown tree, such as \"0.9 + 0.22*dbh\"");
  json.blank();
  json.comment("Sampled plots; see docs/plots.md.");
  add("plots", "table of plots: a CSV file");
  add("plots_columns", "where its columns come from, such as {\"area\": \"SIZE*100\"}");
  add("circles", "concentric circles, such as [\"7=4\", \"30=12\"] (cm and m)");
  add("angle_count", "basal area factor of angle counts in m2/ha; 0: none");
  add("smallest_dbh", "of angle counts in cm");
  add("expansion", "column with the number of trees per ha that each tree stands for");
  add("expansion_area", "these are hectares of the whole plot (plot) or of its share (part)");
  add("subplots", "circles of a plot");
  add("subplot", "column with the subplot of each tree");
  return json.finish(
      "slope_correction", values.at("slope_correction"), "distances were measured along the slope");
}

}  // namespace

std::string study_configuration_for(const data::Table& table,
                                    const Catalogue& catalogue,
                                    const StudyConfiguration& settings) {
  const ordered_json values = settings_json(settings);
  CommentedJson json;
  describe_models(table, catalogue, settings, values, json);
  describe_choice(values, json);
  return describe_inventory(values, json);
}

}  // namespace silvafit::study
