// SPDX-License-Identifier: MIT
// Fits with covariance matrices of few parameters, against nlme.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;

namespace {

/// Twelve groups of four times: y = 1 + t/2 + sin(5 i^2) + height cos(3 g^2) + slope t cos(11 g^2).
data::Table four_times(double height, double slope) {
  std::vector<double> t;
  std::vector<double> y;
  data::TextColumn group;
  for (int i = 1; i <= 48; ++i) {
    const int g = (i + 3) / 4;
    t.push_back((i - 1) % 4 + 1);
    y.push_back(1.0 + 0.5 * t.back() + std::sin(5.0 * i * i) + height * std::cos(3.0 * g * g) +
                slope * t.back() * std::cos(11.0 * g * g));
    group.append(std::to_string(g));
  }
  data::Table table(t.size());
  table.set("t", t);
  table.set("y", y);
  table.set("g", std::move(group));
  return table;
}

fit::FittedModel fitted(const data::Table& table,
                        const std::string& random,
                        const std::string& covariance) {
  const fit::ModelTexts texts{
      .formula = "y ~ a + b*t", .random = random, .covariance = {covariance}};
  return fit::fit_model(fit::specify_model(texts, table), table).fit;
}

}  // namespace

// lme(y ~ t, d, random = ..., method = "ML") of nlme 3.1-162.

TEST_CASE("Compound symmetry of one random effect is its variance") {
  const fit::FittedModel fit = fitted(four_times(1.2, 0.4), "a | g", "compound-symmetry");
  REQUIRE(fit.convergence.converged());
  CHECK(fit.log_likelihood == Approx(-64.9829826662).margin(1e-8));  // ~ 1 | g
}

TEST_CASE("A common variance does not contain the model without one of its effects") {
  // This has -84.8151154301.
  const fit::FittedModel fit = fitted(four_times(8.0, 0.0), "a + b | g", "identity");
  CHECK(fit.convergence.converged());
  CHECK(fit.log_likelihood == Approx(-106.187300009).margin(1e-7));  // list(g = pdIdent(~ t))
}
