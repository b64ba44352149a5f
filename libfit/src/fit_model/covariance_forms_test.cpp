// SPDX-License-Identifier: MIT
// Fits with covariance matrices of few parameters, against nlme.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/intervals.hpp"
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

TEST_CASE("A common variance does not depend on the unit of the response") {
  for (const char* covariance : {"identity", "compound-symmetry"}) {
    for (const double unit : {1e-8, 1e6, 1e8}) {
      data::Table table = four_times(1.2, 0.4);
      const double one = fitted(table, "a + b | g", covariance).log_likelihood;
      std::vector<double> y(table.numbers("y").begin(), table.numbers("y").end());
      for (double& value : y) value *= unit;
      table.set("y", y);
      const fit::FittedModel fit = fitted(table, "a + b | g", covariance);
      INFO(covariance << ", unit " << unit << ": " << fit.convergence.verdict());
      CHECK(fit.convergence.converged());
      CHECK(fit.log_likelihood + 48.0 * std::log(unit) == Approx(one).margin(1e-6));
    }
  }
}

TEST_CASE("A common variance that one effect alone determines is not 0") {
  // Slopes by ten-thousandths of a unit of time: those of the intercept are below the residuals by
  // as much, and the model is that with random slopes alone.
  data::Table table = four_times(0.0, 0.4);
  std::vector<double> t(table.numbers("t").begin(), table.numbers("t").end());
  for (double& value : t) value *= 1e5;
  table.set("t", t);
  const fit::FittedModel both = fitted(table, "a + b | g", "identity");
  const fit::FittedModel slopes = fitted(table, "b | g", "general");
  REQUIRE(both.convergence.converged());
  CHECK_FALSE(both.convergence.has_boundary());
  CHECK(both.log_likelihood == Approx(slopes.log_likelihood).margin(1e-6));
  const auto limits = [&](const fit::FittedModel& fit, const char* name) {
    const fit::Intervals all =
        fit::confidence_intervals(fit, table, {.method = fit::IntervalMethod::kWald});
    const auto found = std::ranges::find(all.parameters, name, &fit::ParameterInterval::name);
    REQUIRE(found != all.parameters.end());
    return std::pair(found->lower, found->upper);
  };
  const auto [lower, upper] = limits(slopes, "sd(b)");
  REQUIRE(lower > 0.0);
  for (const char* name : {"sd(a)", "sd(b)"}) {
    const auto [low, high] = limits(both, name);
    CHECK(low == Approx(lower).epsilon(1e-4));
    CHECK(high == Approx(upper).epsilon(1e-4));
  }
}
