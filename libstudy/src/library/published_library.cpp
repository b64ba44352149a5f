// SPDX-License-Identifier: MIT
#include "library/published_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/study/study.hpp"

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
constexpr std::array<std::string_view, 3> kRoles{"ols", "covariates", "nlme"};

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
  fit.population = fit.conditional = {.r2 = kNaN, .mean_error = kNaN, .rmse = kNaN, .mae = kNaN};
  if (const auto random = model.find("random")) set_random_effects(*random, fit);
  if (const auto statistics = model.find("statistics")) set_statistics(*statistics, fit);
  fit.method = fit::default_method(fit.specification);
  fit.sigma = sigma_of(fit);
  // Publications count the parameters of mixed models differently.
  if (fit.method == fit::Method::kOrdinary) {
    fit.parameter_count = static_cast<int>(fit.estimate.size()) + 1;
  }
  fit.convergence.status = fit::ConvergenceStatus::kPublished;
  fit.convergence.verdict = fmt::format(
      "Published model, not fitted by silvafit: {}; {}.", source, model.at("source").text());
  return result;
}

}  // namespace

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

}  // namespace silvafit::study
