// SPDX-License-Identifier: MIT
#include "silvafit/study/predict_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "silvafit/base/json_values.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/tree_table.hpp"
#include "study/words.hpp"
#include "workflow/repeated_rows.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

constexpr std::array<Word<fit::Level>, 4> kLevels{{{"population", fit::Level::kPopulation},
                                                   {"conditional", fit::Level::kConditional},
                                                   {"calibrated", fit::Level::kCalibrated},
                                                   {"marginal", fit::Level::kMarginal}}};
constexpr std::array<Word<fit::SeenGroups>, 3> kSeenGroups{
    {{"fitted", fit::SeenGroups::kFitted},
     {"new", fit::SeenGroups::kNew},
     {"combined", fit::SeenGroups::kCombined}}};
constexpr std::array<Word<fit::IntervalKind>, 2> kIntervalKinds{
    {{"prediction", fit::IntervalKind::kPrediction},
     {"confidence", fit::IntervalKind::kConfidence}}};
constexpr std::array<Word<fit::NewGroups>, 4> kNewGroups{
    {{"population", fit::NewGroups::kPopulation},
     {"marginal", fit::NewGroups::kMarginal},
     {"missing", fit::NewGroups::kMissing},
     {"error", fit::NewGroups::kError}}};

std::optional<double> coverage_of(const PredictionSettings& settings) {
  if (settings.interval == 0.0) return std::nullopt;
  if (settings.interval > 0.0 && settings.interval < 1.0) return settings.interval;
  throw UsageError(fmt::format("{} is not between 0 and 1, such as 0.95", settings.interval),
                   {.column = "--interval"});
}

PredictResponsesOptions options_of(const PredictionSettings& settings, const Catalogue& catalogue) {
  return {.level = meaning_of(settings.level, kLevels, "--level"),
          .new_groups = meaning_of(settings.new_groups, kNewGroups, "--new-groups"),
          .seen_groups = meaning_of(settings.seen_groups, kSeenGroups, "--seen-groups"),
          .interval = coverage_of(settings),
          .interval_kind = meaning_of(settings.interval_kind, kIntervalKinds, "--interval-kind"),
          .standard_errors = settings.standard_errors,
          .threads = settings.threads,
          .role = settings.role.empty() ? "nlme" : settings.role,
          .other_roles = settings.role.empty(),
          .catalogue = &catalogue};
}

/// Which species of the table the library has no model of, and which it has; empty if none.
std::string note_on_species(const ModelLibrary& library, const data::Table& table) {
  std::set<std::string> known;
  for (const LibraryModel& model : library.models) known.insert(model.species);
  // A model without species is one of all trees.
  if (known.contains("") || !table.has("species")) return {};
  const data::TextColumn species = table.labels("species");
  std::set<std::string> unknown;
  std::size_t trees = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (species.is_missing(row) || known.contains(std::string(species[row]))) continue;
    unknown.emplace(species[row]);
    ++trees;
  }
  if (unknown.empty()) return {};
  const std::vector<std::string> names(unknown.begin(), unknown.end());
  return fmt::format("{} of species without a model in the library: {}; it has models for {}",
                     counted(trees, "tree is", "trees are"),
                     data::list_of(names),
                     data::list_of(std::vector(known.begin(), known.end())));
}

/// Numbers of trees, or "fitted" where the random effects of the fit were used.
void add_trees(const std::string& name, const std::vector<double>& trees, data::Table& table) {
  if (std::ranges::find(trees, kFittedEffects) == trees.end()) return table.set(name, trees);
  data::TextColumn texts;
  for (const double value : trees) {
    if (std::isnan(value)) {
      texts.append_missing();
    } else {
      texts.append(value == kFittedEffects ? "fitted" : data::shortest(value));
    }
  }
  table.set(name, std::move(texts));
}

ordered_json unused_json(const std::vector<UnusedModel>& models) {
  ordered_json list = ordered_json::array();
  for (const UnusedModel& model : models) {
    list.push_back({{"species", text_or_null(model.species)},
                    {"response", model.response},
                    {"model", model.name},
                    {"missing", model.missing},
                    {"instead", text_or_null(model.instead)}});
  }
  return list;
}

/// A copy of a row has its predictions.
void give_to_copies(const std::vector<std::size_t>& place, PredictedResponses& predictions) {
  if (place.empty()) return;
  for (PredictedResponse& one : predictions.responses) {
    for (std::vector<double>* values :
         {&one.value, &one.lower, &one.upper, &one.standard_error, &one.trees}) {
      if (!values->empty()) *values = of_all_rows(*values, place);
    }
  }
  predictions.flags = of_all_rows(predictions.flags, place);
}

/// Measured values, and predicted ones where none is measured.
void fill_with_predictions(const PredictedResponse& response, data::Table& table) {
  std::vector<double> values = response.value;
  if (table.has(response.response) && table.is_numeric(response.response)) {
    const std::span<const double> measured = table.numbers(response.response);
    for (std::size_t row = 0; row < values.size(); ++row) {
      if (!std::isnan(measured[row])) values[row] = measured[row];
    }
  }
  table.set(response.response, std::move(values));
}

void add_quantities(TablePrediction& prediction) {
  const EquationSettings& equations = prediction.settings.equations;
  if (equations.equations.empty()) return;
  data::Table table = prediction.table;
  for (const PredictedResponse& response : prediction.predictions.responses) {
    fill_with_predictions(response, table);
  }
  TreeQuantities found = tree_quantities(table, equations);
  prediction.quantities = std::move(found.quantities);
  std::ranges::move(found.notes, std::back_inserter(prediction.predictions.notes));
}

}  // namespace

TablePrediction predict_table(const data::TableSource& trees,
                              const ModelLibrary& library,
                              const Catalogue& catalogue,
                              const PredictionSettings& settings,
                              const Callbacks& callbacks) {
  const PredictResponsesOptions options = options_of(settings, catalogue);
  const UnitSettings units = library.inventory.units.value_or(UnitSettings{});
  std::vector<std::string> wanted = columns_read(library);
  if (!settings.equations.equations.empty()) wanted.insert(wanted.end(), {"dbh", "h"});
  ObservedTable read = read_model_table(trees,
                                        settings.reading,
                                        {.names = text_columns(library),
                                         .wanted = wanted,
                                         .units = unit_options(units, settings.threads)},
                                        callbacks.note);
  TablePrediction result{.settings = settings};
  result.predictions = predict_responses(library, read.observations(), options);
  give_to_copies(read.place, result.predictions);
  result.table = std::move(read.table);
  result.recognized = std::move(read.recognized);
  std::string unknown = note_on_species(library, result.table);
  if (!unknown.empty()) result.predictions.notes.push_back(std::move(unknown));
  add_quantities(result);
  give_notes(result.predictions.notes, callbacks.note);
  return result;
}

data::Table new_columns(const TablePrediction& prediction) {
  const PredictedResponses& predictions = prediction.predictions;
  data::Table table(predictions.flags.size());
  for (const PredictedResponse& one : predictions.responses) {
    const auto add = [&](const char* ending, const std::vector<double>& values) {
      if (!values.empty()) table.set(one.response + ending, values);
    };
    add("_pred", one.value);
    add("_lower", one.lower);
    add("_upper", one.upper);
    if (prediction.settings.standard_errors) add("_se", one.standard_error);
    if (!one.trees.empty()) add_trees(one.response + "_trees", one.trees, table);
  }
  for (const stand::TreeQuantity& quantity : prediction.quantities) {
    table.set(quantity.name + "_" + quantity.unit, quantity.values);
  }
  data::TextColumn flags;
  for (const std::string& flag : predictions.flags) flags.append(flag);
  table.set("flag", std::move(flags));
  return table;
}

ordered_json json_of(const TablePrediction& prediction, const std::string& out) {
  const PredictedResponses& predictions = prediction.predictions;
  const PredictionSettings& settings = prediction.settings;
  ordered_json predicted = ordered_json::object();
  for (const PredictedResponse& one : predictions.responses) {
    predicted[one.response] =
        std::ranges::count_if(one.value, [](double value) { return !std::isnan(value); });
  }
  std::map<std::string, std::size_t> flags;
  for (const std::string& flag : predictions.flags) {
    if (!flag.empty()) ++flags[flag];
  }
  const bool has_interval = settings.interval > 0.0;
  return {{"schema", "silvafit-predict/1"},
          {"silvafit", SILVAFIT_VERSION},
          {"level", settings.level},
          {"interval", has_interval ? ordered_json(settings.interval) : ordered_json(nullptr)},
          {"interval_kind",
           has_interval ? ordered_json(settings.interval_kind) : ordered_json(nullptr)},
          {"out", text_or_null(out)},
          {"n", predictions.flags.size()},
          {"predicted", std::move(predicted)},
          {"flags", flags},
          {"unused_models", unused_json(predictions.unused)},
          {"recognized", prediction.recognized},
          {"notes", predictions.notes}};
}

}  // namespace silvafit::study
