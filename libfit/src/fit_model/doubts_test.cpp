// SPDX-License-Identifier: MIT
#include "fit_model/doubts.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "silvafit/fit/model_texts.hpp"

using namespace silvafit::fit;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using silvafit::data::Table;

namespace {

/// Trees whose height is 3 + 0.4*dbh plus a small wave, so that no model is exact.
Table doubted_trees() {
  constexpr std::size_t kTrees = 60;
  std::vector<double> dbh;
  std::vector<double> height;
  std::vector<double> dead;
  std::vector<double> seedlings;
  for (std::size_t i = 0; i < kTrees; ++i) {
    const auto number = static_cast<double>(i);
    dbh.push_back(5.0 + 0.5 * number);
    height.push_back(3.0 + 0.4 * dbh.back() + 0.3 * std::sin(number));
    dead.push_back(i % 3 == 0 ? 1.0 : 0.0);
    seedlings.push_back(std::floor(number / 10.0) + static_cast<double>(i % 3));
  }
  Table table(kTrees);
  table.set("h", height);
  table.set("dbh", dbh);
  table.set("height", height);
  std::ranges::transform(height, height.begin(), [](double value) { return std::round(value); });
  table.set("rounded", height);
  table.set("dead", dead);
  table.set("seedlings", seedlings);
  return table;
}

Convergence fitted(const std::string& formula, const FitModelOptions& options = {}) {
  const Table table = doubted_trees();
  return fit_model(specify_model({.formula = formula}, table), table, options).fit.convergence;
}

}  // namespace

TEST_CASE("a misspelt predictor is named first") {
  const Convergence convergence = fitted("h ~ a + b*dhb");
  CHECK_FALSE(convergence.converged());
  CHECK_THAT(convergence.verdict(),
             StartsWith("dhb is not a column of the data and was taken as a parameter; did you "
                        "mean the column dbh?"));
  // All names that were taken as parameters.
  CHECK_THAT(convergence.verdict(), Contains("a, b and dhb were taken as parameters"));
  CHECK(convergence.has(Evidence::Kind::kTakenAsParameter, "dhb"));
  CHECK_THAT(fitted("h ~ 1.3 + A*(1 - exp(-b*diam))").verdict(),
             StartsWith("A, b and diam were taken as parameters"));
}

TEST_CASE("an abbreviated column that the model lacks is named, also if the fit converges") {
  const Convergence convergence = fitted("h ~ dbh*hgt");
  CHECK(convergence.converged());
  CHECK(convergence.has_doubts());
  CHECK_THAT(convergence.verdict(),
             StartsWith("hgt is not a column") && Contains("column height?"));
}

TEST_CASE("parameters of identifiable models are not doubted") {
  for (const char* formula : {"h ~ a + b*dbh", "h ~ 1.3 + a*dbh^b", "h ~ Asym*(1 - exp(-k*dbh))"}) {
    INFO(formula);
    CHECK_FALSE(fitted(formula).has_doubts());
  }
  // The other of two parameters with one effect is held.
  CHECK_FALSE(fitted("h ~ a + u + b*dbh", {.fixed = {{"u", 0.0}}}).has_doubts());
}

TEST_CASE("names with a start value, a bound or a fixed value are parameters") {
  CHECK(fitted("h ~ dbh*hgt").has_doubts());
  CHECK_FALSE(fitted("h ~ dbh*hgt", {.start = {{"hgt", 1.0}}}).has_doubts());
  CHECK_FALSE(fitted("h ~ dbh*hgt", {.bounds = {{"hgt", {.low = 0.0}}}}).has_doubts());
}

TEST_CASE("a response of two values or of counts is named first") {
  CHECK_THAT(fitted("dead ~ a + b*dbh").verdict(),
             StartsWith("The response dead has two values only (0 and 1)"));
  CHECK_THAT(fitted("seedlings ~ a + b*dbh").verdict(),
             StartsWith("All values of seedlings are whole numbers, some of them 0"));
  CHECK_FALSE(fitted("h ~ a + b*dbh").has_doubts());
  // Heights in whole meters have no zeros.
  CHECK_FALSE(fitted("rounded ~ a + b*dbh").has_doubts());
  const Table table = doubted_trees();
  const auto weighted = specify_model(
      {.formula = "seedlings ~ exp(a + b*dbh)", .variance = "power(delta = 0.5)"}, table);
  CHECK_FALSE(fit_model(weighted, table).fit.convergence.has_doubts());
}

TEST_CASE("a code of missing values that is the only negative value is named first") {
  Table table = doubted_trees();
  std::vector<double> height(table.numbers("h").begin(), table.numbers("h").end());
  height[4] = height[9] = -99.0;
  table.set("h", height);
  const auto fitted_to = [&](const char* formula) {
    return fit_model(specify_model({.formula = formula}, table), table).fit.convergence;
  };
  const Convergence doubted = fitted_to("h ~ a + b*dbh");
  CHECK_THAT(doubted.verdict(),
             StartsWith("The only value below 0 in the column h is -99, in 2 of the rows"));
  CHECK(doubted.has(Evidence::Kind::kMissingCode, "h"));
  CHECK(doubted.has_doubts());
  CHECK(fitted_to("height ~ a + b*h").has(Evidence::Kind::kMissingCode, "h"));
  CHECK_FALSE(fitted_to("height ~ a + b*dbh").has_doubts());
  // Columns with other negative values have values.
  height[5] = -2.0;
  table.set("h", height);
  CHECK_FALSE(fitted_to("h ~ a + b*dbh").has_doubts());
}

TEST_CASE("a repeated value far from all others that may be a code is named first") {
  const Table trees = doubted_trees();
  const auto fitted_with = [&](const char* column, double code, const char* formula) {
    Table table = trees;
    std::vector<double> values(table.numbers(column).begin(), table.numbers(column).end());
    values[4] = values[9] = values[12] = code;
    table.set(column, values);
    return fit_model(specify_model({.formula = formula}, table), table).fit.convergence;
  };
  CHECK_THAT(fitted_with("h", 0.0, "h ~ a + b*dbh").verdict(),
             StartsWith("The value 0 in 3 rows of the column h is far from all others"));
  CHECK_THAT(fitted_with("h", 99.9, "h ~ a + b*dbh").verdict(), StartsWith("The value 99.9 in 3"));
  CHECK(fitted_with("dbh", 999.0, "h ~ a + b*dbh").has(Evidence::Kind::kMissingCode, "dbh"));
  // Covariates of 0 are often real, as are other high values.
  CHECK_FALSE(fitted_with("dbh", 0.0, "h ~ a + b*dbh").has_doubts());
  CHECK_FALSE(fitted_with("dbh", 120.0, "h ~ a + b*dbh").has_doubts());
}

TEST_CASE("responses that were imputed are named") {
  Table table = doubted_trees();
  const auto doubted = [&table] {
    return fit_model(specify_model({.formula = "h ~ a + b*dbh"}, table), table).fit.convergence;
  };
  silvafit::data::TextColumn source;
  for (std::size_t row = 0; row < table.rows(); ++row) source.append("measured");
  table.set("h_source", source);
  CHECK_FALSE(doubted().has_doubts());
  silvafit::data::TextColumn filled;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    filled.append(row < 3 ? "imputed" : "measured");
  }
  table.set("h_source", filled);
  CHECK_THAT(doubted().verdict(), StartsWith("h was imputed in 3 of the rows (h_source)"));
  CHECK(doubted().has_doubts());
}

TEST_CASE("models that are not from texts are not doubted") {
  const Table table = doubted_trees();
  const auto result = fit_model(specify_model("h ~ dbh*hgt", {}, table), table);
  CHECK_FALSE(result.fit.convergence.has_doubts());
}
