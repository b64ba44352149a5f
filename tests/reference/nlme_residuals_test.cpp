// SPDX-License-Identifier: MIT
// Residuals against those of R 4.2.2 with nlme 3.1-162, R2 against its linear mixed models;
// bench/r/residuals_nlme.R made the figures.
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "expected.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/residuals.hpp"

using namespace silvafit;
using nlohmann::json;

namespace {

fit::ModelSpecification model_with_residuals(const json& reference, const data::Table& table) {
  fit::ModelSpecification model = fit::specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table);
  const std::string id = reference["id"].get<std::string>();
  const char* const random = id == "nested" ? "a | stand/plot" : "a + b | plot";
  fit::add_random_effects(model, id == "none" ? "a | plot" : random, table);
  model.variance = fit::parse_variance_function(reference["variance"].get<std::string>());
  return model;
}

/// A level's effects, by the groups' labels.
void take_effects(const json& level, fit::EstimatedEffects& term) {
  term.labels.clear();
  term.effects.resize(static_cast<Eigen::Index>(term.names.size()),
                      static_cast<Eigen::Index>(level.size()));
  for (const auto& [label, values] : level.items()) {
    for (std::size_t k = 0; k < term.names.size(); ++k) {
      term.effects(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(term.labels.size())) =
          values[term.names[k]].get<double>();
    }
    term.labels.push_back(label);
  }
}

/// Our fit with nlme's own estimates in it, so that only the definitions are compared.
fit::FittedModel with_estimates(fit::FittedModel fit, const json& reference) {
  fit.estimate = Eigen::Vector2d(reference["fixed"]["a"], reference["fixed"]["b"]);
  fit.sigma = reference["sigma"];
  if (!fit.variance.factors.empty()) fit.variance.factors[0].delta[0] = reference["delta"];
  take_effects(reference["random"]["plot"], fit.random.back());
  if (reference["random"].contains("stand")) {
    take_effects(reference["random"]["stand"], fit.random.front());
  }
  return fit;
}

double largest_difference(const json& reference, const Eigen::VectorXd& ours, const json& rows) {
  double largest = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto row = rows[i].get<Eigen::Index>() - 1;
    largest = std::max(largest, std::abs(ours[row] - reference[i].get<double>()));
  }
  return largest;
}

void check_residuals(const json& reference, const fit::Residuals& ours, double tolerance) {
  const json& residuals = reference["residuals"];
  const auto check = [&](const char* name, const Eigen::VectorXd& values) {
    INFO(reference["id"] << " " << name);
    CHECK(largest_difference(residuals[name], values, reference["rows"]) < tolerance);
  };
  check("fitted_population", ours.population.fitted);
  check("fitted_conditional", ours.conditional.fitted);
  check("response_population", ours.population.raw);
  check("response_conditional", ours.conditional.raw);
  check("pearson_population", ours.population.standardized);
  check("pearson_conditional", ours.conditional.standardized);
  check("normalized_conditional", ours.normalized);
}

}  // namespace

TEST_CASE("residuals are nlme's at both levels", "[reference]") {
  const data::Table table = test::stands();
  const json fits = test::read_expected("nlme_residuals.json")["fits"];
  REQUIRE(fits["residuals"].size() == 3);
  for (const json& reference : fits["residuals"]) {
    const fit::FittedModel fit = fit::fit_model(model_with_residuals(reference, table), table).fit;
    REQUIRE(fit.convergence.converged());
    // From nlme's estimates, which have 15 digits.
    check_residuals(reference, fit::residuals(with_estimates(fit, reference), table), 1e-10);
    // From our own: nlme's variance parameters are exact to some 1e-5, and residuals of up to 4
    // standard deviations with them.
    check_residuals(reference, fit::residuals(fit, table), 2e-4);
  }
}

TEST_CASE("R2 of linear mixed models are Nakagawa's and Johnson's", "[reference]") {
  const data::Table table = test::stands();
  const json shares = test::read_expected("nlme_residuals.json")["fits"]["shares"];
  for (const std::string id : {"intercept", "slope"}) {
    fit::ModelSpecification model = fit::specify_model("h ~ a + b*dbh", {}, table);
    fit::add_random_effects(model, id == "slope" ? "a + b | plot" : "a | plot", table);
    const fit::FittedModel fit = fit::fit_model(model, table).fit;
    REQUIRE(fit.convergence.converged());
    // lme's covariance is exact to about 1e-6.
    CHECK(fit.r2_marginal == Approx(shares[id]["marginal"].get<double>()).epsilon(1e-6));
    CHECK(fit.r2_conditional == Approx(shares[id]["conditional"].get<double>()).epsilon(1e-6));
  }
}
