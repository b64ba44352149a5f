// SPDX-License-Identifier: MIT
#include "silvafit/study/catalogue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>
#include <set>
#include <tuple>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/median.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/data/json_reader.hpp"

namespace silvafit::study {
namespace {

using data::JsonReader;
using Names = std::vector<std::string>;

/// In sensible conditions, 1.2 times the largest DBH.
constexpr const char* kTopDbh = "top_dbh";

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Columns that a base model of a response may use.
Names covariates_of(const std::string& response) {
  return response == "hcb" ? Names{"dbh", "h"} : Names{"dbh"};
}

/// Names that a start rule may use.
Names summary_names(const std::string& response) {
  Names result;
  for (const std::string& column : {std::string("dbh"), std::string("h"), response}) {
    for (const char* summary : {"min", "mean", "max", "median"}) {
      result.push_back(fmt::format("{}_{}", summary, column));
    }
  }
  return result;
}

void check_names(const JsonReader& place, const data::Expression& expression, const Names& known) {
  for (const std::string& name : expression.variables()) {
    if (!contains(known, name)) {
      place.fail(fmt::format("unknown '{}'; available: {}", name, fmt::join(known, ", ")));
    }
  }
}

void check_names(const JsonReader& place,
                 const std::map<std::string, double>& values,
                 const Names& wanted) {
  Names names;
  for (const auto& [name, value] : values) names.push_back(name);
  Names sorted = wanted;
  std::sort(sorted.begin(), sorted.end());
  if (names != sorted) place.fail(fmt::format("must name {}", fmt::join(wanted, ", ")));
}

BaseParameter read_parameter(const JsonReader& json, const std::string& response) {
  json.allow_only({"name", "meaning", "unit", "sign", "start"});
  BaseParameter result{
      .name = json.at("name").text(),
      .meaning = json.at("meaning").text(),
      .unit = json.at("unit").text(),
      .sign = json.at("sign").word<Sign>(),
      .start = json.at("start").expression(),
  };
  check_names(json.at("start"), result.start, summary_names(response));
  return result;
}

void read_formula(const JsonReader& json, BaseModel& model) {
  const JsonReader place = json.at("formula");
  model.formula = place.text();
  try {
    data::Formula formula = data::parse_formula(model.formula);
    if (formula.left != model.response) {
      place.fail(fmt::format("must begin with {} ~", model.response));
    }
    model.mean = std::move(formula.right);
  } catch (const FormulaError& error) {
    place.fail(error.what());
  }
  const Names names = model.parameter_names();
  const Names variables = model.mean.variables();
  Names known = names;
  for (const std::string& column : covariates_of(model.response)) {
    known.push_back(column);
    if (contains(variables, column)) model.covariates.push_back(column);
  }
  check_names(place, model.mean, known);
  for (const std::string& name : names) {
    if (!contains(variables, name)) {
      place.fail(fmt::format("does not use the parameter {}", name));
    }
  }
}

Equivalence read_equivalence(const JsonReader& json, const Names& parameters) {
  json.allow_only({"model", "where", "with"});
  Equivalence result{.model = json.at("model").text()};
  if (const auto where = json.find("where")) result.where = where->expressions_by_name();
  result.with = json.at("with").expressions_by_name();
  for (const auto& [name, expression] : result.where) {
    if (!contains(parameters, name)) json.fail(fmt::format("unknown parameter {}", name));
    check_names(json, expression, parameters);
  }
  for (const auto& [name, expression] : result.with) check_names(json, expression, parameters);
  return result;
}

/// Domain of the model, and limits of its curve.
void read_sense(const JsonReader& json, BaseModel& model) {
  Names known = model.parameter_names();
  known.emplace_back(kTopDbh);
  for (const JsonReader& item : json.at("sensible").items()) {
    item.allow_only({"condition", "otherwise"});
    model.sensible.push_back(
        {.condition = item.at("condition").expression(), .otherwise = item.at("otherwise").text()});
    check_names(item.at("condition"), model.sensible.back().condition, known);
  }
  known.back() = "h";
  if (!contains(model.covariates, "h")) known.pop_back();
  model.at_zero = json.at("at_zero").expression();
  check_names(json.at("at_zero"), model.at_zero, known);
  if (const auto limit = json.find("at_infinity")) {
    model.at_infinity = limit->expression();
    check_names(*limit, *model.at_infinity, known);
  }
}

void read_domain(const JsonReader& json, BaseModel& model) {
  for (const JsonReader& item : json.at("domain").items()) {
    model.domain.push_back(item.expression());
    check_names(item, model.domain.back(), model.covariates);
  }
  for (const JsonReader& item : json.at("invalid").items()) {
    model.invalid.push_back(item.numbers_by_name());
    check_names(item, model.invalid.back(), model.covariates);
  }
}

void read_reference_points(const JsonReader& json, BaseModel& model) {
  for (const JsonReader& item : json.at("reference_points").items()) {
    item.allow_only({"arguments", "parameters", "value"});
    model.reference_points.push_back({.arguments = item.at("arguments").numbers_by_name(),
                                      .parameters = item.at("parameters").numbers_by_name(),
                                      .value = item.at("value").number()});
    check_names(item.at("arguments"), model.reference_points.back().arguments, model.covariates);
    check_names(
        item.at("parameters"), model.reference_points.back().parameters, model.parameter_names());
  }
}

BaseModel read_model(const std::filesystem::path& path) {
  const JsonReader json = JsonReader::open(path);
  json.allow_only({"schema",
                   "id",
                   "name",
                   "response",
                   "formula",
                   "parameters",
                   "monotone",
                   "at_zero",
                   "at_infinity",
                   "sensible",
                   "domain",
                   "invalid",
                   "equals",
                   "reference_points",
                   "notes",
                   "source"});
  json.at("schema").one_of({"silvafit-base-model/1"});
  json.at("response").one_of({"h", "hcb", "cw"});
  BaseModel model;
  model.file = path;
  model.id = json.at("id").text();
  model.name = json.at("name").text();
  model.response = json.at("response").text();
  for (const JsonReader& item : json.at("parameters").items()) {
    model.parameters.push_back(read_parameter(item, model.response));
  }
  read_formula(json, model);
  if (const auto monotone = json.find("monotone")) {
    model.monotone = monotone->one_of({"increasing", "decreasing"}) == 0 ? Monotone::kIncreasing
                                                                         : Monotone::kDecreasing;
  }
  read_sense(json, model);
  read_domain(json, model);
  if (const auto equals = json.find("equals")) {
    for (const JsonReader& item : equals->items()) {
      model.equals.push_back(read_equivalence(item, model.parameter_names()));
    }
  }
  read_reference_points(json, model);
  if (const auto notes = json.find("notes")) model.notes = notes->text();
  model.source = json.at("source").texts();
  return model;
}

/// "M12" as ("M", 12), so that M2 comes before M12.
std::pair<std::string, unsigned long> order_of(const std::string& id) {
  const std::size_t digits = id.find_first_of("0123456789");
  if (digits == std::string::npos) return {id, 0};
  return {id.substr(0, digits), std::strtoul(id.c_str() + digits, nullptr, 10)};
}

void check_together(const std::vector<BaseModel>& models) {
  std::map<std::string, const BaseModel*> by_id;
  for (const BaseModel& model : models) {
    const auto [place, is_new] = by_id.emplace(model.id, &model);
    if (!is_new) {
      throw InputError(fmt::format("{} has the same id {}", place->second->file.string(), model.id),
                       {.file = model.file.string(), .column = "id"});
    }
  }
  for (const BaseModel& model : models) {
    for (const Equivalence& equivalence : model.equals) {
      if (!by_id.contains(equivalence.model)) {
        throw InputError(fmt::format("unknown model {}", equivalence.model),
                         {.file = model.file.string(), .column = "equals"});
      }
    }
  }
}

double evaluate(const data::Expression& expression, const std::map<std::string, double>& values) {
  std::vector<std::string> names;
  std::vector<double> numbers;
  for (const auto& [name, value] : values) {
    names.push_back(name);
    numbers.push_back(value);
  }
  return expression.value(names, numbers);
}

void summarize(const std::string& column,
               const std::vector<double>& values,
               std::map<std::string, double>& summaries) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  summaries["min_" + column] = *low;
  summaries["max_" + column] = *high;
  summaries["mean_" + column] = sum / static_cast<double>(values.size());
  summaries["median_" + column] = median(values);
}

/// The columns that the start rules of a model use.
Names columns_of_start_rules(const BaseModel& model) {
  std::set<std::string> columns;
  for (const BaseParameter& parameter : model.parameters) {
    for (const std::string& name : parameter.start.variables()) {
      columns.insert(name.substr(name.find('_') + 1));
    }
  }
  return {columns.begin(), columns.end()};
}

/// The letters and digits of a name in lower case: `Hossfeld IV` is hossfeldiv. The only accent in
/// names of models is that of Näslund.
std::string letters_of(std::string_view name) {
  std::string letters;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto byte = static_cast<unsigned char>(name[i]);
    const std::string_view pair = name.substr(i, 2);
    if (pair == "ä" || pair == "Ä") {
      letters += 'a';
    } else if (std::isalnum(byte) != 0) {
      letters += static_cast<char>(std::tolower(byte));
    }
  }
  return letters;
}

}  // namespace

std::vector<std::string> BaseModel::parameter_names() const {
  std::vector<std::string> result;
  result.reserve(parameters.size());
  for (const BaseParameter& parameter : parameters) result.push_back(parameter.name);
  return result;
}

double BaseModel::value(const std::map<std::string, double>& arguments,
                        const std::map<std::string, double>& parameter_values) const {
  std::map<std::string, double> all = arguments;
  all.insert(parameter_values.begin(), parameter_values.end());
  return evaluate(mean, all);
}

std::string BaseModel::violated_condition(std::map<std::string, double> values,
                                          double top_dbh_cm) const {
  values[kTopDbh] = top_dbh_cm;
  for (const SensibleCondition& each : sensible) {
    if (evaluate(each.condition, values) != 1.0) return each.otherwise;
  }
  return "";
}

Catalogue Catalogue::load(const std::filesystem::path& models_directory) {
  const std::filesystem::path directory = models_directory / "base";
  Catalogue result;
  if (kind_of(directory) == PathKind::kFolder) {
    for (const auto& file : files_in_folder(directory, ".json")) {
      result.models_.push_back(read_model(file));
    }
  }
  if (result.models_.empty()) {
    throw InputError("no base models were found", {.file = directory.string()});
  }
  std::sort(result.models_.begin(), result.models_.end(), [](const auto& a, const auto& b) {
    return std::tuple(order_of(a.id), a.file) < std::tuple(order_of(b.id), b.file);
  });
  check_together(result.models_);
  return result;
}

const BaseModel& Catalogue::find(std::string_view id) const {
  const BaseModel* named = nullptr;
  bool is_ambiguous = false;
  std::vector<std::string> names;
  for (const BaseModel& model : models_) {
    if (model.id == id) return model;
    names.push_back(fmt::format("{} ({})", model.id, model.name));
    if (letters_of(model.name) != letters_of(id)) continue;
    is_ambiguous = is_ambiguous || named != nullptr;
    named = &model;
  }
  if (named != nullptr && !is_ambiguous) return *named;
  throw UsageError(fmt::format("{} {}; available: {}",
                               is_ambiguous ? "several models are called" : "unknown model",
                               id,
                               fmt::join(names, ", ")));
}

std::vector<const BaseModel*> Catalogue::candidates(std::string_view response) const {
  std::vector<const BaseModel*> result;
  for (const BaseModel& model : models_) {
    if (model.response == response) result.push_back(&model);
  }
  return result;
}

std::vector<double> start_values(const BaseModel& model, const data::Table& table) {
  const Names columns = columns_of_start_rules(model);
  std::vector<std::span<const double>> sources;
  for (const std::string& column : columns) sources.push_back(table.numbers(column));
  std::vector<std::vector<double>> complete(sources.size());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool is_complete = std::ranges::all_of(
        sources, [row](std::span<const double> source) { return std::isfinite(source[row]); });
    if (!is_complete) continue;
    for (std::size_t k = 0; k < sources.size(); ++k) complete[k].push_back(sources[k][row]);
  }
  std::map<std::string, double> summaries;
  std::size_t next = 0;
  for (const std::string& column : columns) {
    std::vector<double>& values = complete[next++];
    if (values.empty()) {
      throw UsageError("no row has all the values that the start values need", {.column = column});
    }
    summarize(column, values, summaries);
  }
  std::vector<double> result;
  for (const BaseParameter& parameter : model.parameters) {
    result.push_back(evaluate(parameter.start, summaries));
  }
  return result;
}

}  // namespace silvafit::study
