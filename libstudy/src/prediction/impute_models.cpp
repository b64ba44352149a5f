// SPDX-License-Identifier: MIT
#include "prediction/impute_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/parallel.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::study {
namespace {

/// The default curve of heights: two parameters, a finite limit,
/// increasing everywhere, and hardly correlated with the plots' differences in shape.
constexpr const char* kHeightModel = "M1";
constexpr const char* kAll = "all:";
constexpr const char* kPlot = "plot";

/// A mean function to try.
struct Mean {
  std::string model{};  ///< id in the catalogue
  fit::ModelSpecification specification;
  fit::FitModelOptions options{};
};

std::vector<const BaseModel*> chosen_models(const Catalogue& catalogue,
                                            const ImputeOptions& options) {
  if (options.models.empty()) {
    if (options.response == "h") return {&catalogue.find(kHeightModel)};
    return catalogue.candidates(options.response);
  }
  std::vector<const BaseModel*> models;
  for (const std::string& name : options.models) {
    if (name.starts_with(kAll)) {
      for (const BaseModel* model : catalogue.candidates(name.substr(4))) models.push_back(model);
    } else {
      models.push_back(&catalogue.find(name));
    }
  }
  return models;
}

std::vector<Mean> means_of(const data::Table& table,
                           const Catalogue& catalogue,
                           const ImputeOptions& options) {
  if (!options.formula.empty()) {
    return {{.specification = fit::specify_model(options.formula, {}, table)}};
  }
  std::vector<Mean> means;
  for (const BaseModel* model : chosen_models(catalogue, options)) {
    require_domain(*model, table);
    Mean mean{.model = model->id, .specification = fit::specify_model(model->formula, {}, table)};
    const std::vector<double> starts = start_values(*model, table);
    for (std::size_t k = 0; k < starts.size(); ++k) {
      mean.options.rule[model->parameters[k].name] = starts[k];
    }
    means.push_back(std::move(mean));
  }
  return means;
}

/// Groups of a table, which may be part of a larger table.
std::size_t group_count(const data::Table& table, const std::string& column) {
  const data::TextColumn labels = table.labels(column);
  std::set<std::string_view> groups;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!labels.is_missing(row)) groups.insert(labels[row]);
  }
  return groups.size();
}

/// Adds a note if there are too few plots for the default random effects.
void note_few_plots(const data::Table& measured,
                    const ImputeOptions& options,
                    std::vector<std::string>& notes) {
  const std::string group = plot_column(measured, options);
  if (!options.random.empty() || group.empty() || group_count(measured, group) > 1) return;
  notes.push_back(fmt::format(
      "fewer than two values of '{}' have a measured {}, so the model has no random effects{}",
      group,
      options.response,
      options.interval > 0.0 ? ", and the intervals lack the differences between them" : ""));
}

/// Whether the chosen method fits curves without random effects.
bool is_without_effects(const ImputeOptions& options) {
  return options.method == fit::Method::kOrdinary || options.method == fit::Method::kGeneralized;
}

/// Random effects to try in turn: the requested ones, or two, one and none.
std::vector<std::string> random_texts(const fit::ModelSpecification& specification,
                                      const data::Table& table,
                                      const ImputeOptions& options) {
  if (!options.random.empty()) return {options.random};
  const std::string group = plot_column(table, options);
  if (group.empty() || group_count(table, group) < 2 || is_without_effects(options)) {
    return {"none"};
  }
  const std::vector<std::string> names = specification.coefficient_names();
  std::vector<std::string> texts;
  if (names.size() > 1) {
    texts.push_back(fmt::format("{} + {} | {}", names[0], names[1], group));
  }
  texts.push_back(fmt::format("{} | {}", names[0], group));
  texts.emplace_back("none");
  return texts;
}

/// The variance function; by the column dbh unless another is requested.
std::string variance_text(const data::Table& table, const ImputeOptions& options) {
  if (!options.variance.empty()) return options.variance;
  if (options.method == fit::Method::kOrdinary) return "none";
  return table.has("dbh") ? "power(dbh)" : "power";
}

struct Attempt {
  std::optional<fit::FittedModel> fit{};
  std::vector<std::string> failures{};
};

Attempt fitted(const Mean& mean, const data::Table& table, const ImputeOptions& options) {
  Attempt attempt;
  for (const std::string& random : random_texts(mean.specification, table, options)) {
    fit::ModelSpecification specification = mean.specification;
    if (random != "none") fit::add_random_effects(specification, random, table);
    specification.variance = fit::parse_variance_function(variance_text(table, options));
    fit::FitModelOptions how = mean.options;
    if (options.method) how.method = options.method;
    // A method for random effects is ignored if there are none.
    const bool is_idle = random == "none" && options.random.empty();
    if (is_idle && !is_without_effects(options)) how.method.reset();
    fit::FittedModel fit = fit::fit_model(specification, table, how).fit;
    fit.model = mean.model;
    if (fit.convergence.converged()) {
      attempt.fit = std::move(fit);
      return attempt;
    }
    attempt.failures.push_back(fmt::format("{}{}random effects {}: {}",
                                           mean.model,
                                           mean.model.empty() ? "" : ", ",
                                           random,
                                           fit.convergence.verdict()));
  }
  return attempt;
}

}  // namespace

std::string plot_column(const data::Table& table, const ImputeOptions& options) {
  if (!options.group.empty()) return options.group;
  return table.has(kPlot) ? kPlot : "";
}

void require_model_numbers(const data::Table& table,
                           const Catalogue& catalogue,
                           const ImputeOptions& options) {
  std::vector<std::string> columns;
  if (!options.formula.empty()) {
    columns = fit::specify_model(options.formula, {}, table).predictors();
  } else {
    for (const BaseModel* model : chosen_models(catalogue, options)) {
      columns.insert(columns.end(), model->covariates.begin(), model->covariates.end());
      require_domain_of_covariates(*model, table);
    }
  }
  const fit::VarianceFunction variance =
      fit::parse_variance_function(variance_text(table, options));
  for (const fit::VarianceFactor& factor : variance.factors) {
    if (!factor.column.empty()) columns.push_back(factor.column);
  }
  require_numbers(table, columns);
}

fit::FittedModel imputation_model(const data::Table& measured,
                                  const Catalogue& catalogue,
                                  const ImputeOptions& options,
                                  std::vector<std::string>& notes) {
  const std::vector<Mean> means = means_of(measured, catalogue, options);
  if (means.empty()) {
    throw UsageError(
        fmt::format("the catalogue has no model for '{}'; give a formula", options.response));
  }
  for (const Mean& mean : means) {
    if (mean.specification.formula.left == options.response) continue;
    throw UsageError(fmt::format("{} is a model for {}, not for {}",
                                 mean.model.empty() ? "the formula" : mean.model,
                                 mean.specification.formula.left,
                                 options.response));
  }
  note_few_plots(measured, options, notes);
  std::vector<Attempt> attempts(means.size());
  parallel_for(means.size(), options.threads, [&](std::size_t i) {
    attempts[i] = fitted(means[i], measured, options);
  });
  const Attempt* best = nullptr;
  for (const Attempt& attempt : attempts) {
    notes.insert(notes.end(), attempt.failures.begin(), attempt.failures.end());
    if (!attempt.fit) continue;
    if (best == nullptr || attempt.fit->aic() < best->fit->aic()) best = &attempt;
  }
  if (best == nullptr) {
    throw NumericalError(fmt::format("no model for {} converged: {}",
                                     options.response,
                                     notes.empty() ? "no model was tried" : notes.back()));
  }
  return *best->fit;
}

}  // namespace silvafit::study
