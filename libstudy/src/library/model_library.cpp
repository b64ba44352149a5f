// SPDX-License-Identifier: MIT
#include "silvafit/study/model_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "library/published_library.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "study/unit_settings_json.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;
using nlohmann::ordered_json;

constexpr std::string_view kSchema = "silvafit-library/1";

std::string text_or_empty(const JsonReader& json, std::string_view key) {
  const JsonReader value = json.at(key);
  return value.is_null() ? std::string() : value.text();
}

void check_schema(const JsonReader& json) {
  const std::string schema = json.text();
  if (schema == kSchema) return;
  if (schema.starts_with("silvafit-library/")) {
    json.fail(fmt::format(
        "{} was written by a newer version of silvafit; this version reads {}", schema, kSchema));
  }
  json.fail(fmt::format("must be {} or the JSON of `silvafit fit`, not \"{}\"", kSchema, schema));
}

LibraryModel plain_model(fit::FittedModel fit) {
  std::string response = fit.specification.formula.left;
  return {.response = std::move(response), .fit = std::move(fit)};
}

/// What `silvafit fit --json` prints.
ModelLibrary read_fits(const JsonReader& json) {
  ModelLibrary library;
  if (!json.has("fits")) {
    library.models.push_back(plain_model(fit::from_json(json)));
    return library;
  }
  for (const JsonReader& fit : json.at("fits").items()) {
    library.models.push_back(plain_model(fit::from_json(fit)));
  }
  return library;
}

LibraryModel read_model(const JsonReader& json) {
  LibraryModel model{.species = text_or_empty(json, "species"),
                     .response = json.at("response").text(),
                     .unit = text_or_empty(json, "unit"),
                     .role = text_or_empty(json, "role"),
                     .fit = fit::from_json(json.at("fit"))};
  if (model.response != model.fit.specification.formula.left) {
    json.at("response").fail("is not the left-hand side of the formula");
  }
  return model;
}

ModelLibrary read_models(const JsonReader& json) {
  check_schema(json.at("schema"));
  const JsonReader inventory = json.at("inventory");
  ModelLibrary library{
      .inventory = {.file = text_or_empty(inventory, "file"),
                    .fingerprint = text_or_empty(inventory, "fingerprint"),
                    .trees = static_cast<std::size_t>(inventory.at("trees").count_or_zero())}};
  if (const auto commonest = inventory.find("commonest_dbh")) {
    library.inventory.commonest_dbh_cm = commonest->numbers_by_name();
  }
  if (const auto units = inventory.find("structural_units")) {
    library.inventory.units = read_unit_settings(*units);
  }
  for (const JsonReader& model : json.at("models").items()) {
    library.models.push_back(read_model(model));
  }
  return library;
}

bool has_schema(const JsonReader& json, std::string_view beginning) {
  return json.has("schema") && json.at("schema").text().starts_with(beginning);
}

bool is_plain_fit(const JsonReader& json) {
  return json.has("fits") || has_schema(json, "silvafit-fit/");
}

ordered_json inventory_json(const LibraryInventory& inventory) {
  ordered_json json{{"file", text_or_null(inventory.file)},
                    {"fingerprint", text_or_null(inventory.fingerprint)},
                    {"trees", inventory.trees},
                    {"commonest_dbh", inventory.commonest_dbh_cm}};
  if (inventory.units) json["structural_units"] = unit_settings_json(*inventory.units);
  return json;
}

}  // namespace

std::string to_json(const ModelLibrary& library) {
  ordered_json models = ordered_json::array();
  for (const LibraryModel& model : library.models) {
    models.push_back({{"species", text_or_null(model.species)},
                      {"response", model.response},
                      {"unit", text_or_null(model.unit)},
                      {"role", text_or_null(model.role)},
                      {"fit", fit::json_of(model.fit)}});
  }
  const ordered_json result{{"schema", kSchema},
                            {"silvafit", SILVAFIT_VERSION},
                            {"inventory", inventory_json(library.inventory)},
                            {"models", std::move(models)}};
  return json_text(result, 1) + "\n";
}

void write_library(const ModelLibrary& library, const std::filesystem::path& path) {
  write_file(path, to_json(library));
}

ModelLibrary read_library(const std::filesystem::path& path) {
  return read_library(JsonReader::open(path));
}

ModelLibrary read_library(const JsonReader& json) {
  if (has_schema(json, "silvafit-published-models/")) return published_library(json);
  return is_plain_fit(json) ? read_fits(json) : read_models(json);
}

std::vector<std::string> published_libraries(const std::filesystem::path& models_directory) {
  std::vector<std::string> names;
  const std::filesystem::path folder = models_directory / "published";
  try {
    for (const auto& file : files_in_folder(folder, ".json")) names.push_back(file.stem().string());
  } catch (const InputError& error) {
    throw InputError(fmt::format("the published libraries: {}; reinstall silvafit, or set "
                                 "SILVAFIT_DATA_DIR",
                                 error.message()),
                     {.file = folder.string()});
  }
  return names;
}

ModelLibrary find_library(const std::string& name_or_file,
                          const std::filesystem::path& models_directory) {
  if (is_there(name_or_file)) return read_library(name_or_file);
  const std::vector<std::string> names = published_libraries(models_directory);
  if (std::ranges::find(names, name_or_file) != names.end()) {
    return read_library(models_directory / "published" / (name_or_file + ".json"));
  }
  throw InputError(fmt::format("is neither a file nor a published library; published libraries: {}",
                               fmt::join(names, ", ")),
                   {.file = name_or_file});
}

}  // namespace silvafit::study
