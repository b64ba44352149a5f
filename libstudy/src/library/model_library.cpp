// SPDX-License-Identifier: MIT
#include "silvafit/study/model_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/study/study.hpp"
#include "study/settings_json.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

fit::ModelSpecification specification_of(const JsonReader& model) {
  fit::ModelSpecification specification{.formula = data::parse_formula(model.at("formula").text())};
  for (const auto& [name, terms] : model.at("parameters").members_by_name()) {
    specification.parameters.push_back(fit::parse_stored_parameter_model(name, terms.text()));
  }
  return specification;
}

void set_coefficients(const JsonReader& model, fit::FittedModel& fit) {
  const std::map<std::string, double> given = model.at("fixed").numbers_by_name();
  fit.coefficient_names = fit.specification.coefficient_names();
  const auto p = static_cast<Index>(fit.coefficient_names.size());
  fit.estimate.resize(p);
  for (Index j = 0; j < p; ++j) {
    const std::string& name = fit.coefficient_names[static_cast<std::size_t>(j)];
    const auto found = given.find(name);
    if (found == given.end()) model.at("fixed").fail("has no value of " + name);
    fit.estimate[j] = found->second;
  }
  fit.covariance = MatrixXd::Constant(p, p, kNaN);
}

/// Variances that are not printed are NaN.
VectorXd standard_deviations(const JsonReader& variances) {
  const std::vector<JsonReader> items = variances.items();
  VectorXd result(static_cast<Index>(items.size()));
  for (Index k = 0; k < result.size(); ++k) {
    const JsonReader& item = items[static_cast<std::size_t>(k)];
    result[k] = item.is_null() ? kNaN : std::sqrt(item.not_negative());
  }
  return result;
}

void set_random_effects(const JsonReader& random, fit::FittedModel& fit) {
  const std::vector<std::string> effects = random.at("effects").texts();
  const VectorXd deviations = standard_deviations(random.at("variance"));
  const std::vector<JsonReader> rows = random.at("correlation").items();
  const auto q = static_cast<Index>(effects.size());
  if (deviations.size() != q || rows.size() != effects.size()) {
    random.fail("needs one variance and one row of correlations for each random effect");
  }
  for (const std::string& effect : effects) {
    if (std::ranges::find(fit.coefficient_names, effect) == fit.coefficient_names.end()) {
      random.at("effects").fail(effect + " is not a coefficient of the model");
    }
  }
  fit.specification.random = {{.coefficients = effects, .group = random.at("group").text()}};
  fit::EstimatedEffects& term = fit.random.emplace_back();
  term.names = effects;
  term.covariance.resize(q, q);
  for (Index i = 0; i < q; ++i) {
    const std::vector<double> correlations = rows[static_cast<std::size_t>(i)].numbers();
    if (static_cast<Index>(correlations.size()) != q)
      random.at("correlation").fail("is not square");
    for (Index j = 0; j < q; ++j) {
      term.covariance(i, j) =
          correlations[static_cast<std::size_t>(j)] * deviations[i] * deviations[j];
    }
  }
  term.effects.resize(q, 0);
}

void set_statistics(const JsonReader& statistics, fit::FittedModel& fit) {
  const auto value = [&](std::string_view key) {
    const auto found = statistics.find(key);
    return found ? found->number() : kNaN;
  };
  fit::FitStatistics& published = fit.has_random_effects() ? fit.conditional : fit.population;
  published = {.r2 = value("r2"), .mean_error = value("mean_error"), .rmse = value("rmse")};
  published.mae = value("mae");
  if (const auto n = statistics.find("n")) fit.observations = static_cast<Index>(n->count());
  fit.log_likelihood = value("log_likelihood");
}

/// Of the base models the residual standard deviation follows from the RMSE; else it is unknown.
double sigma_of(const fit::FittedModel& fit) {
  if (fit.has_random_effects() || !fit.specification.variance.is_constant()) return kNaN;
  const auto n = static_cast<double>(fit.observations);
  const auto p = static_cast<double>(fit.estimate.size());
  return n > p ? fit.population.rmse * std::sqrt(n / (n - p)) : kNaN;
}

constexpr std::array<std::string_view, 3> kLevels{"base", "covariates", "mixed"};

LibraryModel library_model(const JsonReader& model, const std::string& source) {
  LibraryModel result{.species = model.at("species").text(),
                      .response = model.at("response").text(),
                      .fit = fit::FittedModel(specification_of(model))};
  result.unit = unit_of(result.response);
  result.role = kRoles[model.at("level").one_of({kLevels[0], kLevels[1], kLevels[2]})];
  fit::FittedModel& fit = result.fit;
  if (const auto base = model.find("base_model")) fit.model = base->text();
  if (const auto variance = model.find("variance")) {
    fit.specification.variance = fit::parse_variance_function(variance->at("function").text());
  }
  fit.variance = fit::VarianceEstimate::missing(fit.specification.variance);
  set_coefficients(model, fit);
  if (const auto random = model.find("random")) set_random_effects(*random, fit);
  if (const auto statistics = model.find("statistics")) set_statistics(*statistics, fit);
  fit.method = fit::default_method(fit.specification);
  fit.sigma = sigma_of(fit);
  // Publications count the parameters of mixed models differently.
  if (fit.method == fit::Method::kOrdinary) {
    fit.parameter_count = static_cast<int>(fit.estimate.size()) + 1;
  }
  fit.convergence.conclude(
      fit::ConvergenceStatus::kPublished,
      {.kind = fit::Finding::Kind::kPublished, .names = {source, model.at("source").text()}});
  return result;
}

/// The models of a file of published coefficients, schema silvafit-published-models/1: levels base,
/// covariates and mixed get the roles ols, covariates and nlme. Values that a source does not print
/// (standard errors, EBLUPs, parameters of variance functions) is NaN.
/// \throws InputError that names file and key where an entry cannot be used
ModelLibrary published_library(const JsonReader& document) {
  ModelLibrary library{.inventory = {.file = document.at("id").text()}};
  if (const auto commonest = document.find("commonest_dbh")) {
    library.inventory.commonest_dbh_cm = commonest->numbers_by_name();
  }
  for (const JsonReader& model : document.at("models").items()) {
    try {
      library.models.push_back(library_model(model, document.at("source").text()));
    } catch (const FormulaError& error) {
      model.fail(error.what());
    }
  }
  return library;
}

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
  if (kind_of(name_or_file) == PathKind::kFolder) {
    const std::filesystem::path inside = std::filesystem::path(name_or_file) / "library.json";
    throw InputError(is_there(inside)
                         ? fmt::format("is a folder; its library is {}", inside.string())
                         : "is a folder without a library.json of a study",
                     {.file = name_or_file});
  }
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
