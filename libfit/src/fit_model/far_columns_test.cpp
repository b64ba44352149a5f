// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using Catch::Matchers::Contains;

namespace {

/// Eight groups of y = 5 + 0.2 x + u + e in the years from 1990 to 2020, the standard deviation of
/// e growing by 6 % a year; `since` are the years since 2005.
data::Table calendar_years() {
  Random random(4);
  std::vector<double> year, since, x, y;
  data::TextColumn group;
  for (int g = 0; g < 8; ++g) {
    const double effect = random.normal(0.0, 2.0);
    for (int k = 0; k < 8; ++k) {
      group.append(std::to_string(g));
      year.push_back(1990.0 + std::floor(31.0 * random.uniform()));
      since.push_back(year.back() - 2005.0);
      x.push_back(10.0 * random.uniform());
      const double sd = 0.5 * std::exp(0.06 * since.back());
      y.push_back(5.0 + 0.2 * x.back() + effect + random.normal(0.0, sd));
    }
  }
  data::Table table;
  table.set("g", group);
  table.set("year", year);
  table.set("since", since);
  table.set("x", x);
  table.set("y", y);
  return table;
}

fit::FittedModel fit_of(const data::Table& table,
                        const std::string& formula,
                        const std::string& variance,
                        fit::Method method) {
  const fit::ModelTexts texts{.formula = formula, .random = "a | g", .variance = variance};
  return fit::fit_model(fit::specify_model(texts, table), table, {.method = method}).fit;
}

}  // namespace

TEST_CASE("an exponential variance function does not depend on the origin of its column") {
  const data::Table table = calendar_years();
  for (const fit::Method method : {fit::Method::kLindstromBates, fit::Method::kLaplace}) {
    const auto far = fit_of(table, "y ~ a + b*x", "exponential(year)", method);
    const auto near = fit_of(table, "y ~ a + b*x", "exponential(since)", method);
    INFO(far.convergence.verdict());
    REQUIRE(far.convergence.converged());
    REQUIRE(near.convergence.converged());
    // Both searches stop within a millionth of a standard error.
    CHECK(far.log_likelihood == Approx(near.log_likelihood).epsilon(1e-10));
    const double delta = near.variance.delta();
    CHECK(far.variance.delta() == Approx(delta).epsilon(1e-6));
    CHECK(std::log(far.sigma) + 2005.0 * far.variance.delta() ==
          Approx(std::log(near.sigma)).epsilon(1e-5));
    CHECK(far.standard_errors()[1] == Approx(near.standard_errors()[1]).epsilon(1e-5));
  }
}

TEST_CASE("powers of a column far from 0 are refused, and only what helps is advised") {
  // The standard deviation would be that of year 1 times 2005^145.
  const data::Table table = calendar_years();
  for (const fit::Method method : {fit::Method::kLindstromBates, fit::Method::kLaplace}) {
    for (const char* variance : {"power(year)", "constant-plus-power(year)"}) {
      const auto fit = fit_of(table, "y ~ a + b*x", variance, method);
      CHECK_FALSE(fit.convergence.converged());
      CHECK_THAT(fit.convergence.verdict(), Contains("exponential") && Contains("year"));
    }
  }
  const auto shifted =
      fit_of(table, "y ~ a + b*(year - 2005)", "power(year)", fit::Method::kLindstromBates);
  CHECK_THAT(shifted.convergence.verdict(), !Contains("in the formula"));
}
