// SPDX-License-Identifier: MIT
// Crossed random effects and three nested levels against lme4 1.1-31 and TMB 1.9.2;
// bench/r/reference_crossed.R drew the trees and made the figures; those of nlme 3.1-162 are by
// bench/r/reference_effects.R.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "expected.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "silvafit/fit/prediction.hpp"
#include "silvafit/fit/residuals.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

data::Table trees() { return data::read_csv_table(test::reference_data("crossed.csv")); }

fit::FitResult fitted(const json& reference, fit::Method method) {
  const data::Table table = trees();
  const std::string formula = reference["formula"];
  const std::string random = reference["random"];
  fit::FitModelOptions options;
  options.method = method;
  options.reml = reference.value("reml", false);
  return fit::fit_model(
      fit::specify_model(fit::ModelTexts{.formula = formula, .random = random}, table),
      table,
      options);
}

json reference_of(const std::string& id) {
  const json file = test::read_expected("crossed.json");
  for (const json& fit : file["fits"]) {
    if (fit["id"] == id) return fit;
  }
  FAIL("no reference " << id);
  return {};
}

/// The name that lme4 gives to the groups of a term: the finest column first.
std::string name_of_lme4(const fit::RandomEffects& term) {
  std::string name;
  for (const std::string& column : term.within) {
    name = name.empty() ? column : column + ":" + name;
  }
  if (name.empty()) return term.group;
  return term.within.size() > 1 ? term.group + ":(" + name + ")" : term.group + ":" + name;
}

/// The coefficients of lme4's names.
std::string coefficient_of(const json& name) { return name == "x" ? "b1" : "b0"; }

void check_components(const fit::FittedModel& fit, const json& reference) {
  // bobyqa stops where the deviance is flat to rounding: standard deviations to about 1e-6, less
  // precisely where there are four regions only.
  constexpr double kPrecise = 1e-4;
  for (const json& part : reference["components"]) {
    if (part["group"] == "Residual") continue;
    const auto& terms = fit.specification.random;
    const auto term = std::ranges::find(terms, part["group"].get<std::string>(), name_of_lme4);
    REQUIRE(term != terms.end());
    const fit::EstimatedEffects& of = fit.random[static_cast<std::size_t>(term - terms.begin())];
    const double value = part["sdcor"];
    const bool is_correlation = part.contains("second") && !part["second"].is_null();
    if (is_correlation) {
      CHECK(of.correlation()(0, 1) == Approx(value).epsilon(kPrecise));
      continue;
    }
    const auto k = std::ranges::find(of.names, coefficient_of(part["first"])) - of.names.begin();
    CHECK(of.sd()[k] == Approx(value).epsilon(kPrecise));
  }
}

}  // namespace

TEST_CASE("linear models with crossed effects and three levels are those of lme4", "[reference]") {
  const json file = test::read_expected("crossed.json");
  for (const json& reference : file["fits"]) {
    if (reference.contains("method")) continue;
    INFO(reference["id"]);
    for (const fit::Method method : {fit::Method::kLindstromBates, fit::Method::kLaplace}) {
      if (reference["reml"] && method == fit::Method::kLaplace) continue;
      const fit::FitResult result = fitted(reference, method);
      const fit::FittedModel& fit = result.fit;
      REQUIRE(fit.convergence.converged());
      // The likelihood is flat at its maximum, where bobyqa is 1e-6 away.
      CHECK(fit.log_likelihood == Approx(reference["logLik"].get<double>()).margin(1e-8));
      for (const char* name : {"b0", "b1"}) {
        const auto j = fit.coefficient_names[0] == name ? 0 : 1;
        CHECK(fit.estimate[j] == Approx(reference["fixed"][name].get<double>()).epsilon(1e-6));
        // lb has nlme's factor N / (N - p) with maximum likelihood; the observed information of
        // laplace includes the variances.
        if (method == fit::Method::kLaplace) continue;
        const double n = static_cast<double>(fit.observations);
        const double factor = reference["reml"] ? 1.0 : std::sqrt(n / (n - 2.0));
        const double error = reference["std_errors"][name];
        CHECK(fit.standard_errors()[j] == Approx(factor * error).epsilon(1e-4));
      }
      CHECK(fit.sigma == Approx(reference["sigma"].get<double>()).epsilon(1e-5));
      check_components(fit, reference);
      for (std::size_t i = 0; i < result.rows.size(); ++i) {
        const double expected = reference["fitted"][result.rows[i]];
        CHECK(result.fitted_conditional[static_cast<Eigen::Index>(i)] ==
              Approx(expected).margin(1e-4));
      }
    }
  }
}

TEST_CASE("blocks, identities and interactions of random effects are those of nlme's book",
          "[reference]") {
  const json file = test::read_expected("nlme_effects.json");
  for (const json& reference : file["fits"]) {
    INFO(reference["id"]);
    const data::Table table = data::read_csv_table(test::reference_data(reference["data"]));
    fit::ModelTexts texts{.formula = reference["formula"], .random = reference["random"]};
    if (reference["parameter"] != "") texts.sub_models = {reference["parameter"]};
    if (reference["diagonal"]) texts.covariance = {"diagonal", "diagonal"};
    fit::FitModelOptions options;
    options.method = fit::Method::kLindstromBates;
    options.reml = reference["reml"];
    const fit::FitResult result = fit::fit_model(specify_model(texts, table), table, options);
    const fit::FittedModel& fit = result.fit;
    CHECK(fit.convergence.converged());
    // nlme's optimum of variances is at about 1e-6 of their logarithms.
    CHECK(fit.log_likelihood == Approx(reference["logLik"].get<double>()).margin(1e-6));
    CHECK(fit.sigma == Approx(reference["sigma"].get<double>()).epsilon(1e-4));
    const json& fixed = reference["fixed"];
    REQUIRE(static_cast<std::size_t>(fit.estimate.size()) == fixed.size());
    const double n = static_cast<double>(fit.observations);
    const double p = static_cast<double>(fixed.size());
    const double factor = options.reml ? 1.0 : std::sqrt(n / (n - p));
    for (std::size_t j = 0; j < fixed.size(); ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      const double error = reference["std_errors"][j];
      CHECK(fit.estimate[k] == Approx(fixed[j].get<double>()).margin(1e-4 * error));
      CHECK(fit.standard_errors()[k] == Approx(factor * error).epsilon(1e-4));
    }
    for (std::size_t i = 0; i < result.rows.size(); ++i) {
      const double expected = reference["fitted"][result.rows[i]];
      CHECK(result.fitted_conditional[static_cast<Eigen::Index>(i)] ==
            Approx(expected).margin(1e-4 * fit.sigma));
    }
  }
}

TEST_CASE("Laplace's likelihood of curves with crossed effects and three levels is that of TMB",
          "[reference]") {
  const json file = test::read_expected("crossed.json");
  for (const json& reference : file["fits"]) {
    if (!reference.contains("method")) continue;
    INFO(reference["id"]);
    const fit::FittedModel fit = fitted(reference, fit::Method::kLaplace).fit;
    REQUIRE(fit.convergence.converged());
    // TMB ends at a gradient of 1e-13.
    CHECK(fit.log_likelihood == Approx(reference["logLik"].get<double>()).margin(1e-7));
    for (const char* name : {"a", "b"}) {
      const auto j = fit.coefficient_names[0] == name ? 0 : 1;
      CHECK(fit.estimate[j] == Approx(reference["fixed"][name].get<double>()).epsilon(1e-5));
      CHECK(fit.standard_errors()[j] ==
            Approx(reference["std_errors"][name].get<double>()).epsilon(1e-4));
    }
    const double log_sigma = reference["parameters"]["log_sigma"][0];
    CHECK(std::log(fit.sigma) == Approx(log_sigma).margin(1e-5));
    const fit::EstimatedEffects& finest =
        fit.random[reference["id"] == "curve_levels" ? fit.random.size() - 1 : 0];
    const double sd = std::abs(reference["parameters"]["factor"][0].get<double>());
    CHECK(finest.sd()[0] == Approx(sd).epsilon(1e-4));
  }
}

TEST_CASE("a fit with crossed effects predicts, is stored, and refuses what it cannot do") {
  const json reference = reference_of("plot_year_ml");
  const data::Table table = trees();
  const fit::FitResult result = fitted(reference, fit::Method::kLindstromBates);
  const fit::FittedModel stored = fit::from_json(fit::to_json(result.fit, 1), "fit.json");
  CHECK(fit::are_crossed(stored.specification.random));
  CHECK(fit::to_json(stored, 1) == fit::to_json(result.fit, 1));
  const auto values = fit::predict(stored, table, fit::Level::kConditional, {}).value;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    CHECK(values[static_cast<Eigen::Index>(row)] ==
          Approx(reference["fitted"][row].get<double>()).margin(1e-4));
  }

  // A new year in a known plot: the effect of the plot remains.
  data::Table one = table.select(std::vector<std::size_t>{0});
  one.set("year", std::vector<double>{1999.0});
  const auto of_plot = fit::predict(stored, one, fit::Level::kConditional, {});
  const auto population = fit::predict(stored, one, fit::Level::kPopulation, {.interval = 0.95});
  CHECK(of_plot.unknown_terms == std::vector<unsigned>{2});  // the second term
  const auto& plots = stored.random[0].labels;
  const auto plot = std::ranges::find(plots, std::string(table.labels("plot_id")[0]));
  CHECK(of_plot.value[0] - population.value[0] ==
        Approx(stored.random[0].effects(0, plot - plots.begin())).epsilon(1e-10));
  CHECK(population.lower[0] < population.value[0]);

  using Catch::Matchers::Contains;
  // Its variance is part of that of a new tree.
  const auto errors =
      fit::predict(stored, one, fit::Level::kConditional, {.standard_errors = true});
  const double of_year = stored.random[1].covariance(0, 0);
  CHECK(errors.prediction_error[0] ==
        Approx(std::sqrt(std::pow(errors.mean_error[0], 2) + of_year + std::pow(stored.sigma, 2)))
            .epsilon(1e-12));
  CHECK(std::isnan(fit::residuals(stored, table).marginal[0]));
}

TEST_CASE("crossed groups that the data cannot distinguish are named") {
  data::Table table = trees();
  table.set("one", std::vector<double>(table.rows(), 1.0));
  std::vector<double> rows;
  for (std::size_t row = 0; row < table.rows(); ++row) rows.push_back(static_cast<double>(row));
  table.set("row", rows);
  using Catch::Matchers::Contains;
  const auto fit = [&](const char* random) {
    return fit::fit_model(
        fit::specify_model(fit::ModelTexts{.formula = "h ~ a + b*dbh", .random = random}, table),
        table,
        {});
  };
  CHECK_THROWS_WITH(fit("a | plot_id + one"),
                    Contains("`a | one`") && Contains("all 214 rows are in the group '1'"));
  CHECK_THROWS_WITH(fit("a | plot_id + row"),
                    Contains("`a | row`") && Contains("214 groups have 214 random effects"));
  fit::FitModelOptions quadrature;
  quadrature.method = fit::Method::kQuadrature;
  const auto crossed = fit::specify_model(
      fit::ModelTexts{.formula = "h ~ a + b*dbh", .random = "a | plot_id + year"}, table);
  CHECK_THROWS_WITH(fit::fit_model(crossed, table, quadrature), Contains("laplace"));
}
