// SPDX-License-Identifier: MIT
#include "silvafit/study/predict_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "silvafit/base/json_values.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/idle_settings.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "silvafit/study/tree_table.hpp"
#include "study/settings_json.hpp"
#include "workflow/flow.hpp"
#include "workflow/repeated_rows.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

/// The species that a library's models are for, or distinguish; each once.
std::vector<std::string> species_of(const ModelLibrary& library) {
  std::set<std::string> result;
  const auto add = [&](const std::string& column, const std::vector<std::string>& labels) {
    if (column == "species") result.insert(labels.begin(), labels.end());
  };
  for (const LibraryModel& model : library.models) {
    if (!model.species.empty()) result.insert(model.species);
    for (const fit::ColumnLevels& levels : model.fit.levels) add(levels.column, levels.labels);
    for (const fit::VarianceFactorEstimate& factor : model.fit.variance.factors) {
      add(factor.factor.stratum, factor.strata);
    }
    if (!model.fit.random.empty()) {
      add(model.fit.specification.random.front().group, model.fit.random.front().labels);
    }
  }
  return {result.begin(), result.end()};
}

/// Counts the trees of species without a model in the library.
class UnknownSpecies {
 public:
  explicit UnknownSpecies(const ModelLibrary& library) {
    for (const LibraryModel& model : library.models) known_.insert(model.species);
  }

  void add(const data::Table& table) {
    // A model without a species is for all trees.
    if (known_.contains("") || !table.has("species")) return;
    const data::TextColumn species = table.labels("species");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (species.is_missing(row) || known_.contains(std::string(species[row]))) continue;
      unknown_.emplace(species[row]);
      ++trees_;
    }
  }

  /// Empty if there are none.
  std::string note() const {
    if (unknown_.empty()) return {};
    return fmt::format("{} of species without a model in the library: {}; it has models for {}",
                       counted(trees_, "tree is", "trees are"),
                       data::list_of(std::vector(unknown_.begin(), unknown_.end())),
                       data::list_of(std::vector(known_.begin(), known_.end())));
  }

 private:
  std::set<std::string> known_{};
  std::set<std::string> unknown_{};
  std::size_t trees_ = 0;
};

/// Gives copies of rows the predictions of their originals.
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

/// The groups of the models, as random effects of one coefficient; empty if they are nested or
/// crossed, since labels then are not alone.
std::string groups_of(const ModelLibrary& library) {
  std::set<std::string> groups;
  for (const LibraryModel& model : library.models) {
    for (const fit::RandomEffects& term : model.fit.specification.random) {
      groups.insert(term.group_text());
    }
  }
  const bool is_one =
      groups.size() == 1 && groups.begin()->find_first_of("/:") == std::string::npos;
  return is_one ? "a | " + *groups.begin() : std::string();
}

/// Predicts a table or its parts, and collects notes on all rows.
class PredictionRun {
 public:
  PredictionRun(const ModelLibrary& library,
                const Catalogue& catalogue,
                const PredictionSettings& settings)
      : library_(library),
        settings_(settings),
        catalogue_(catalogue),
        units_(library.inventory.units.value_or(UnitSettings{})),
        unknown_(library) {}

  const UnitSettings& units() const { return units_; }

  /// \param state  of earlier parts; null for a whole table, whose notes are reported at once
  TablePrediction predict(const data::TableSource& rows,
                          ReadingState* state,
                          const NoteCallback& note) {
    std::vector<std::string> wanted = columns_read(library_);
    if (!settings_.equations.equations.empty()) wanted.insert(wanted.end(), {"dbh", "h"});
    ObservedTable read = read_model_table(rows,
                                          settings_.reading,
                                          {.names = text_columns(library_),
                                           .random = groups_of(library_),
                                           .wanted = std::move(wanted),
                                           .units = unit_options(units_, settings_.threads),
                                           .keeps_sums = true,
                                           .species = species_of(library_),
                                           .state = state},
                                          note);
    TablePrediction result{.settings = settings_};
    result.predictions = predict_responses(library_, read.observations(), settings_, &catalogue_);
    give_to_copies(read.place, result.predictions);
    result.table = std::move(read.table);
    result.recognized = std::move(read.recognized);
    add_quantities(result);
    unknown_.add(result.table);
    marginal_difference_ = std::max(marginal_difference_, result.predictions.marginal_difference);
    return result;
  }

  /// Notes on all rows predicted so far, besides those on the choice of models.
  std::vector<std::string> notes() const {
    std::vector<std::string> notes{note_on_marginal_means(marginal_difference_), unknown_.note()};
    std::erase(notes, "");
    return notes;
  }

 private:
  const ModelLibrary& library_;
  const PredictionSettings& settings_;
  const Catalogue& catalogue_;
  UnitSettings units_;
  UnknownSpecies unknown_;
  double marginal_difference_ = 0.0;
};

/// The column whose groups must be whole in each part; empty if rows are independent.
std::string column_of_groups(const ModelLibrary& library,
                             const PredictionRun& run,
                             const std::vector<std::string>& header,
                             const PredictionSettings& settings) {
  std::set<std::string> coarsest;
  for (const LibraryModel& model : library.models) {
    if (settings.level != fit::Level::kCalibrated) continue;
    const fit::ModelSpecification& of = model.fit.specification;
    if (model.fit.has_random_effects()) {
      coarsest.insert(of.random.front().group);
    } else if (of.correlation && of.correlation->group.empty()) {
      throw UsageError(
          "the residuals of all rows are correlated, so the file cannot be read in parts",
          {.column = "`stream`"});
    } else if (of.correlation) {
      coarsest.insert(of.correlation->group);
    }
  }
  // Indices requested by --columns are computed from the trees of a plot.
  data::Table columns(0);
  for (const char* const name : {"x", "y", "dbh"}) columns.set(name, std::vector<double>());
  for (const std::string& name : header) {
    if (!name.empty()) columns.set(name, std::vector<double>());
  }
  const bool needs_plots = !structure_names_in(settings.reading.columns, columns).empty();
  if (needs_plots && run.units().per != stand::SearchScope::kPlot) {
    throw UsageError(
        "structural indices of the library are computed among all trees (`per=stand`), so the file "
        "cannot be read in parts",
        {.column = "`stream`"});
  }
  if (needs_plots && coarsest.empty()) coarsest.insert("plot");
  if (coarsest.size() > 1) {
    throw UsageError(
        fmt::format("the models have random effects of several columns ({}), so the file cannot be "
                    "read in parts of whole groups",
                    fmt::join(coarsest, ", ")),
        {.column = "`stream`"});
  }
  return coarsest.empty() ? "" : *coarsest.begin();
}

void add_to(const TablePrediction& part, PredictionSummary& summary) {
  const PredictedResponses& predictions = part.predictions;
  summary.trees += predictions.flags.size();
  for (std::size_t i = 0; i < predictions.responses.size(); ++i) {
    const PredictedResponse& one = predictions.responses[i];
    if (i == summary.predicted.size()) summary.predicted.emplace_back(one.response, 0);
    summary.predicted[i].second += static_cast<std::size_t>(
        std::ranges::count_if(one.value, [](double value) { return !std::isnan(value); }));
  }
  for (const std::string& flag : predictions.flags) {
    if (!flag.empty()) ++summary.flags[flag];
  }
  summary.unused = predictions.unused;
  summary.recognized = part.recognized;
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

}  // namespace

PredictionSummary predict_trees(const data::TableSource& trees,
                                const ModelLibrary& library,
                                const Catalogue& catalogue,
                                const PredictionSettings& settings,
                                bool is_in_parts,
                                const PredictionSink& sink,
                                const Callbacks& callbacks) {
  IdleReasons idle;
  const bool has_roles = std::ranges::any_of(
      library.models, [](const LibraryModel& model) { return !model.role.empty(); });
  if (!has_roles) idle["role"] = "on this library, whose models have no roles";
  const auto has_used = [&](const auto& property) {
    return std::ranges::any_of(library.models, [&](const LibraryModel& model) {
      return (settings.role.empty() || model.role == settings.role) && property(model.fit);
    });
  };
  const auto has_effects = [](const fit::FittedModel& fit) { return fit.has_random_effects(); };
  const auto is_correlated = [](const fit::FittedModel& fit) {
    return fit.specification.correlation.has_value();
  };
  // Calibration needs random effects or correlated residuals, other levels random effects.
  const bool has_level = has_used(has_effects) ||
                         (settings.level == fit::Level::kCalibrated && has_used(is_correlated));
  if (!has_level) idle["level"] = "on these models, which have no random effects";
  refuse_idle_settings(settings, {}, idle);
  refuse_idle_settings(settings.equations);
  PredictionRun run(library, catalogue, settings);
  PredictionSummary summary{.settings = settings};
  TableFlow flow(
      trees,
      settings.reading,
      {.is_in_parts = is_in_parts, .threads = settings.threads},
      [&](const std::vector<std::string>& header) {
        return column_of_groups(library, run, header, settings);
      },
      callbacks.note);
  const auto finish = [&] {
    for (std::string& note : run.notes()) summary.notes.push_back(std::move(note));
    if (is_in_parts) give_notes(summary.recognized, callbacks.note);
    give_notes(summary.notes, callbacks.note);
  };
  ReadingState state;
  while (const auto rows = flow.next()) {
    TablePrediction part = run.predict(
        *rows, is_in_parts ? &state : nullptr, is_in_parts ? NoteCallback() : callbacks.note);
    part.is_in_file_order = !flow.is_sorted();
    add_to(part, summary);
    for (const std::string& note : part.predictions.notes) {
      if (std::ranges::find(summary.notes, note) == summary.notes.end()) {
        summary.notes.push_back(note);
      }
    }
    if (!is_in_parts) {
      finish();
      part.predictions.notes = summary.notes;
    }
    sink(*rows, part);
    if (is_in_parts && callbacks.progress) {
      callbacks.progress("trees", summary.trees, flow.rows());
    }
  }
  if (is_in_parts) finish();
  return summary;
}

TablePrediction predict_table(const data::TableSource& trees,
                              const ModelLibrary& library,
                              const Catalogue& catalogue,
                              const PredictionSettings& settings,
                              const Callbacks& callbacks) {
  TablePrediction result;
  const auto take = [&](const data::TableSource&, TablePrediction& all) {
    result = std::move(all);
  };
  predict_trees(trees, library, catalogue, settings, false, take, callbacks);
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

ordered_json json_of(const PredictionSummary& summary, const std::string& out) {
  const PredictionSettings& settings = summary.settings;
  ordered_json predicted = ordered_json::object();
  for (const auto& [response, trees] : summary.predicted) predicted[response] = trees;
  const ordered_json words = settings_json(settings);
  const bool has_interval = settings.interval > 0.0;
  return {{"schema", "silvafit-predict/1"},
          {"silvafit", SILVAFIT_VERSION},
          {"level", words["level"]},
          {"interval", has_interval ? ordered_json(settings.interval) : ordered_json(nullptr)},
          {"interval_kind",
           settings.wants_errors() ? ordered_json(word_of(settings.kind_of_errors()))
                                   : ordered_json(nullptr)},
          {"out", text_or_null(out)},
          {"n", summary.trees},
          {"predicted", std::move(predicted)},
          {"flags", summary.flags},
          {"unused_models", unused_json(summary.unused)},
          {"recognized", summary.recognized},
          {"notes", summary.notes}};
}

}  // namespace silvafit::study
