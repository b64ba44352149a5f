// SPDX-License-Identifier: MIT
#include "silvafit/fit/shared_fit.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <string>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/model_texts.hpp"

namespace silvafit::fit {
namespace {

/// Heights of Meyer curves whose limit differs between plots of three trees.
data::Table heights(std::size_t plots) {
  Random random(5);
  data::TextColumn plot;
  std::vector<double> dbh;
  std::vector<double> h;
  for (std::size_t k = 0; k < plots; ++k) {
    const double limit = 25.0 + 2.0 * random.normal();
    for (int tree = 0; tree < 3; ++tree) {
      plot.append("p" + std::to_string(k));
      dbh.push_back(random.uniform(8.0, 48.0));
      h.push_back(1.3 + limit * (1.0 - std::exp(-0.06 * dbh.back())) + 0.8 * random.normal());
    }
  }
  data::Table table;
  table.set("plot", std::move(plot));
  table.set("dbh", std::move(dbh));
  table.set("h", std::move(h));
  return table;
}

data::Table first_rows(const data::Table& table, std::size_t count) {
  std::vector<std::size_t> rows(count);
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  return table.select(rows);
}

std::vector<std::size_t> parts_of(const data::Table& table, std::size_t rows) {
  std::vector<std::size_t> parts;
  for (std::size_t row = 0; row < table.rows(); ++row) parts.push_back(row / rows);
  return parts;
}

ModelSpecification meyer(const data::Table& table) {
  return specify_model({.formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", .random = "a | plot"}, table);
}

TEST_CASE("a small sample leads to the maximum of all data, and does not limit its precision") {
  // The standard error of a mean of 5000 groups is 14 times smaller than of 25 groups.
  const data::Table all = heights(5000);
  const FitModelOptions options{.method = Method::kLaplace};
  const ModelSpecification model = meyer(all);
  const FittedModel alone = fit_model(model, all, options).fit;
  const FittedModel shared = fit_shared(
      model, {.sample = first_rows(all, 75), .own = all, .parts = parts_of(all, 300)}, options);
  INFO(shared.convergence.verdict());
  REQUIRE(shared.convergence.converged());
  CHECK(shared.observations == 15000);
  // Both searches end within 1e-5 standard errors of the maximum, about which the likelihood is
  // flat; sums of 15000 terms are rounded to 1e-9.
  CHECK(shared.log_likelihood == Approx(alone.log_likelihood).epsilon(0).margin(1e-6));
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double error = alone.standard_errors()[k];
    CHECK(shared.estimate[k] == Approx(alone.estimate[k]).epsilon(0).margin(1e-4 * error));
    CHECK(shared.standard_errors()[k] == Approx(error).epsilon(1e-4));
  }
  CHECK(shared.degrees_of_freedom == alone.degrees_of_freedom);
  CHECK(shared.random.back().labels == alone.random.back().labels);
  CHECK((shared.random.back().effects - alone.random.back().effects).cwiseAbs().maxCoeff() < 1e-5);
}

TEST_CASE("the parts determine only the order of sums") {
  const data::Table all = heights(200);
  const FitModelOptions options{.method = Method::kInteraction};
  const auto fit = [&](std::size_t rows) {
    return fit_shared(
        meyer(all), {.sample = all, .own = all, .parts = parts_of(all, rows)}, options);
  };
  const FittedModel fine = fit(3);
  const FittedModel coarse = fit(600);
  CHECK(fine.log_likelihood == Approx(coarse.log_likelihood).epsilon(1e-10));
  CHECK(fine.population.rmse == Approx(coarse.population.rmse).epsilon(1e-10));
}

TEST_CASE("models that cannot be shared are refused") {
  const data::Table all = heights(20);
  const auto fit = [&](const ModelTexts& texts, const FitModelOptions& options) {
    return fit_shared(specify_model(texts, all), {.sample = all}, options);
  };
  const ModelTexts meyer{.formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", .random = "a | plot"};
  CHECK_THROWS_AS(fit(meyer, {.method = Method::kLindstromBates}), UsageError);
  CHECK_THROWS_AS(fit(meyer, {.method = Method::kLaplace, .fixed = {{"a", 25.0}}}), UsageError);
  ModelTexts strata = meyer;
  strata.variance = "power(fitted | plot)";
  CHECK_THROWS_AS(fit(strata, {.method = Method::kLaplace}), UsageError);
}

}  // namespace
}  // namespace silvafit::fit
