// SPDX-License-Identifier: MIT
#include "silvafit/study/study_configuration.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/expression.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/variance_function.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/setting_names.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;

/// Gives a text to a function that may throw; the error names the key.
template <typename Read>
void checked(const JsonReader& json, Read read) {
  try {
    read(json.text());
  } catch (const UsageError& error) {
    json.fail(error.what());
  }
}

/// \throws InputError that names a candidate that is neither a formula nor in the catalogue
void check_candidates(const JsonReader& json, const Catalogue* catalogue) {
  const auto found = json.find("candidates");
  if (!found) return;
  for (const auto& [response, list] : found->members_by_name()) {
    const std::vector<JsonReader> items = list.items();
    if (items.empty()) list.fail("has no candidate");
    for (const JsonReader& item : items) {
      checked(item, [catalogue](const std::string& candidate) {
        if (candidate.find('~') != std::string::npos) {
          data::parse_formula(candidate);
        } else if (catalogue != nullptr) {
          catalogue->find(candidate);
        }
      });
    }
  }
}

/// \throws InputError that names a text that is no variance function
void check_variance_functions(const JsonReader& json) {
  const auto found = json.find("variance_functions");
  if (!found) return;
  for (const JsonReader& item : found->items()) {
    checked(item, [](const std::string& text) { fit::parse_variance_function(text); });
  }
}

/// The settings of a document: all of a study.json, a part of a run.json.
JsonReader settings_of(const JsonReader& json) {
  const auto schema = json.find("schema");
  if (!schema) return json;
  schema->one_of({"silvafit-run/1"});
  return json.at("options");
}

using nlohmann::ordered_json;

/// Lines of JSON that each end in a comment.
class CommentedJson {
 public:
  void comment(const std::string& text) { text_ += "  // " + text + "\n"; }
  void part(const std::string& text) {
    if (!text_.empty()) text_ += "\n";
    comment(text);
  }
  void add(const std::string& key, const ordered_json& value, const std::string& note) {
    end_ = text_.size() + fmt::formatted_size("  \"{}\": {}", key, json_text(value));
    text_ += fmt::format("  \"{}\": {},  // {}\n", key, json_text(value), note);
  }
  void add_object(const std::string& key, const std::vector<std::string>& lines) {
    text_ += fmt::format("  \"{}\": {{\n", key);
    for (const std::string& line : lines) text_ += fmt::format("    {}\n", line);
    text_ += "  },\n";
  }
  /// The last value has no comma.
  std::string finish() {
    text_.erase(end_, 1);
    return "{\n" + text_ + "}\n";
  }

 private:
  std::string text_{};
  std::size_t end_ = 0;  ///< of the last value
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

/// Writes each setting with its help; a blank line and a sentence begin each part.
class SettingsText {
 public:
  SettingsText(const data::Table& table,
               const Catalogue& catalogue,
               const StudyConfiguration& settings)
      : table_(table), catalogue_(catalogue), settings_(settings) {
    each_setting(settings, values_);
  }

  template <typename T>
  void operator()(const data::Setting<const T>& setting) {
    const std::string key(setting.key);
    const auto part = parts().find(key);
    if (part != parts().end()) json_.part(part->second);
    if (key == "candidates") {
      json_.comment(std::string(setting.help));
      json_.add_object(key, candidate_lines(responses(), settings_.study.candidates, catalogue_));
      return;
    }
    const bool is_responses = key == "responses";
    json_.add(key,
              is_responses ? ordered_json(responses()) : values_.json().at(key),
              std::string(setting.help) + further_note(key));
  }
  std::string finish() { return json_.finish(); }

 private:
  /// The first setting of each part.
  static const std::map<std::string, std::string>& parts() {
    static const std::map<std::string, std::string> texts{
        {"species", "Models"},
        {"criteria", "The choice at each level"},
        {"columns", "The inventory; columns as {\"dbh\": \"DBH_cm\", \"x\": \"xk/10\"}"},
        {"window", "Structural units"},
        {"plots", "Sampled plots; see docs/plots.md"}};
    return texts;
  }
  std::vector<std::string> responses() const { return responses_for(table_, settings_.study); }
  std::string further_note(const std::string& key) const {
    if (key == "species") return "; " + species_note(table_);
    if (key != "covariates") return "";
    const std::vector<std::string> columns = possible_covariates(table_, settings_.reading.columns);
    return columns.empty() ? "" : fmt::format(": {}", fmt::join(columns, ", "));
  }

  const data::Table& table_;
  const Catalogue& catalogue_;
  const StudyConfiguration& settings_;
  SettingsWriter values_{};
  CommentedJson json_{};
};

}  // namespace

StudyConfiguration read_study_configuration(const std::filesystem::path& path,
                                            const Catalogue* catalogue,
                                            const GivenSettings& given) {
  const JsonReader json = settings_of(JsonReader::parse(read_file(path), path.string(), true));
  StudyConfiguration settings = given.settings;
  SettingsReader reader(json, path.parent_path(), given.is_given);
  each_setting(settings, reader);
  reader.finish();
  check_candidates(json, catalogue);
  check_variance_functions(json);
  for (std::string& text : settings.study.variance_functions) {
    text = fit::parse_variance_function(text).text();
  }
  if (!settings.units.circle.empty() && !settings.units.window.empty()) {
    json.at("circle").fail("give either a circle or a window");
  }
  try {
    refuse_idle(settings);
  } catch (const UsageError& error) {
    const std::string key = name_of_place(error.place().column);
    if (json.find(key) && !(given.is_given && given.is_given(key))) {
      json.at(key).fail(error.message());
    }
    throw;
  }
  return settings;
}

void refuse_idle(const StudyConfiguration& settings, const GivenName& given_name) {
  StudyConfiguration all = settings;
  all.units.further.insert(
      all.units.further.end(), settings.study.covariates.begin(), settings.study.covariates.end());
  refuse_idle_settings(all, given_name);
}

StudyConfiguration seen_from(const std::filesystem::path& folder, StudyConfiguration settings) {
  const std::filesystem::path from = followed(folder.empty() ? "." : folder);
  for (std::string* const file : {&settings.units.window, &settings.sampling.plots_file}) {
    if (file->empty() || std::filesystem::path(*file).is_absolute()) continue;
    *file = followed(*file).lexically_proximate(from).string();
  }
  return settings;
}

std::string study_configuration_for(const data::Table& table,
                                    const Catalogue& catalogue,
                                    const StudyConfiguration& settings) {
  SettingsText text(table, catalogue, settings);
  each_setting(settings, text);
  return text.finish();
}

}  // namespace silvafit::study
