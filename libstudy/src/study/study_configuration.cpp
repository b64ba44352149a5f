// SPDX-License-Identifier: MIT
#include "silvafit/study/study_configuration.hpp"

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/variance_function.hpp"
#include "silvafit/study/setting_list.hpp"
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
  return settings;
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
