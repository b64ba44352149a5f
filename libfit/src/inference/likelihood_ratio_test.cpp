// SPDX-License-Identifier: MIT
#include "silvafit/fit/likelihood_ratio.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/comparison.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Contains;

namespace {

constexpr int kPlots = 12;
constexpr int kTrees = 8;

/// A straight line whose intercept differs by plot.
data::Table lines(double spread, std::uint64_t seed = 3) {
  Random random(seed);
  data::Table table;
  data::TextColumn plot;
  std::vector<double> x;
  std::vector<double> z;
  std::vector<double> y;
  for (int i = 0; i < kPlots; ++i) {
    const double effect = random.normal(0.0, spread);
    for (int j = 0; j < kTrees; ++j) {
      plot.append(std::to_string(i));
      x.push_back(j - 3.5);
      z.push_back(random.normal());
      y.push_back(10.0 + effect + 2.0 * x.back() + random.normal());
    }
  }
  table.set("plot", plot);
  table.set("x", x);
  table.set("z", z);
  table.set("y", y);
  return table;
}

FittedModel fitted(const data::Table& table,
                   const std::vector<std::string>& sub_models,
                   const char* random,
                   const char* variance = "none",
                   Covariance covariance = Covariance::kGeneral,
                   const FitModelOptions& options = {}) {
  ModelSpecification model = specify_model("y ~ a + b*x", sub_models, table);
  if (*random != '\0') add_random_effects(model, random, table);
  for (RandomEffects& term : model.random) term.covariance = covariance;
  model.variance = parse_variance_function(variance);
  return fit_model(model, table, options).fit;
}

double tail(int freedom, double x) {
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), x));
}

std::string refusal(const FittedModel& larger, const FittedModel& smaller) {
  try {
    likelihood_ratio_test(larger, smaller);
  } catch (const UsageError& error) {
    return error.message();
  }
  return {};
}

}  // namespace

TEST_CASE("mixtures of chi-squared distributions have the tails of their parts") {
  // Tables of the half-and-half mixtures (Fitzmaurice, Laird and Ware 2011, appendix C): the 5 %
  // points of q and q + 1 degrees of freedom for q = 0 to 3, printed to two decimals.
  const std::vector<double> points{2.71, 5.14, 7.05, 8.76};
  for (int q = 0; q < 4; ++q) {
    const ChiBarSquared mixture{.base = q, .weights = {0.5, 0.5}};
    CHECK(mixture.upper_tail(points[static_cast<std::size_t>(q)]) == Approx(0.05).margin(2e-4));
  }
  CHECK(ChiBarSquared{.base = 0, .weights = {0.5, 0.5}}.upper_tail(0.0) == 1.0);
  CHECK(ChiBarSquared{.base = 2}.upper_tail(6.0) == Approx(std::exp(-3.0)).epsilon(1e-12));
}

TEST_CASE("the p-value of a regular likelihood ratio is the upper tail of chi-squared") {
  // The 5 % and 1 % points as tables print them (Abramowitz and Stegun, table 26.8).
  const auto tail_of = [](double statistic, int freedom) {
    return ChiBarSquared{.base = freedom}.upper_tail(statistic);
  };
  CHECK(tail_of(3.84146, 1) == Approx(0.05).epsilon(1e-5));
  CHECK(tail_of(5.99146, 2) == Approx(0.05).epsilon(1e-5));
  CHECK(tail_of(7.81473, 3) == Approx(0.05).epsilon(1e-5));
  CHECK(tail_of(6.63490, 1) == Approx(0.01).epsilon(1e-5));
  CHECK(tail_of(13.2767, 4) == Approx(0.01).epsilon(1e-5));
  // With two degrees of freedom the tail is exp(-x/2), however far out.
  CHECK(tail_of(200.0, 2) == Approx(std::exp(-100.0)).epsilon(1e-12));
  CHECK(tail_of(std::numeric_limits<double>::infinity(), 2) == 0.0);
}

TEST_CASE("independent variances have binomial weights") {
  CHECK(independent_variances(3).weights == std::vector<double>{0.125, 0.375, 0.375, 0.125});
  CHECK(independent_variances(1).text() == "1/2 chi-squared(0) + 1/2 chi-squared(1)");
}

TEST_CASE("one variance has the half-and-half mixture, a further effect that of Stram and Lee") {
  const data::Table table = lines(0.4);
  const FittedModel none = fitted(table, {}, "");
  const FittedModel one = fitted(table, {}, "a | plot");
  const FittedModel two = fitted(table, {}, "a + b | plot");
  REQUIRE(one.convergence.converged());
  REQUIRE(two.convergence.converged());
  const NestedTest first = likelihood_ratio_test(one, none);
  CHECK(first.degrees_of_freedom == 1);
  CHECK(first.statistic == 2.0 * (one.log_likelihood - none.log_likelihood));
  CHECK(first.p_chi_squared == Approx(tail(1, first.statistic)).epsilon(1e-12));
  CHECK(first.p == Approx(0.5 * tail(1, first.statistic)).epsilon(1e-12));
  const NestedTest second = likelihood_ratio_test(two, one);
  CHECK(second.degrees_of_freedom == 2);
  CHECK(second.reference.base == 1);
  CHECK(second.reference.weights == std::vector<double>{0.5, 0.5});
}

TEST_CASE("an additional covariate shifts the mixture") {
  const data::Table table = lines(0.5);
  const FittedModel smaller = fitted(table, {}, "");
  const FittedModel larger = fitted(table, {"a ~ 1 + z"}, "a | plot");
  const NestedTest test = likelihood_ratio_test(larger, smaller);
  CHECK(test.reference.base == 1);
  CHECK(test.reference.weights == std::vector<double>{0.5, 0.5});
  // Covariates alone are regular.
  const NestedTest regular = likelihood_ratio_test(larger, fitted(table, {}, "a | plot"));
  CHECK(regular.reference.text() == "chi-squared with 1 degree of freedom");
  CHECK(regular.p == regular.p_chi_squared);
}

TEST_CASE("the note on a variance function at its bound is kept with random effects") {
  const data::Table table = lines(0.5);
  FittedModel smaller = fitted(table, {}, "");
  smaller.specification.variance = parse_variance_function("power(x)");
  const auto note = [&](const char* random, Covariance covariance) {
    FittedModel larger = fitted(table, {}, random, "none", covariance);
    larger.specification.variance = parse_variance_function("constant-plus-power(x)");
    ++larger.parameter_count;  // the constant
    return likelihood_ratio_test(larger, smaller).note;
  };
  const auto edge = Contains("at a boundary in the smaller model");
  CHECK_THAT(note("a | plot", Covariance::kGeneral), edge);
  CHECK_THAT(note("a + b | plot", Covariance::kGeneral), edge && Contains("; several correlated"));
  CHECK_THAT(note("a + b | plot", Covariance::kDiagonal), edge && Contains("; the weights assume"));
}

TEST_CASE("a larger model that fits exactly has p = 0, one that is not more likely p = 1") {
  const data::Table table = lines(0.5);
  const FittedModel smaller = fitted(table, {}, "");
  FittedModel larger = fitted(table, {"a ~ 1 + z"}, "");
  larger.log_likelihood = std::numeric_limits<double>::infinity();
  CHECK(likelihood_ratio_test(larger, smaller).p == 0.0);
  CHECK(likelihood_ratio_test(larger, smaller).p_chi_squared == 0.0);
  larger.log_likelihood = smaller.log_likelihood;
  CHECK(likelihood_ratio_test(larger, smaller).p == 1.0);
  CHECK(likelihood_ratio_test(larger, smaller).note.empty());
  larger.log_likelihood = smaller.log_likelihood - 1.0;
  CHECK(likelihood_ratio_test(larger, smaller).p == 1.0);
  CHECK_THAT(likelihood_ratio_test(larger, smaller).note, Contains("ended at a lower maximum"));
  for (const double rounding : {-1e-13, 1e-13}) {
    larger.log_likelihood = smaller.log_likelihood * (1.0 + rounding);
    CHECK(likelihood_ratio_test(larger, smaller).statistic == 0.0);
    CHECK(likelihood_ratio_test(larger, smaller).p == 1.0);
    CHECK(likelihood_ratio_test(larger, smaller).note.empty());
  }
  larger.log_likelihood = -std::numeric_limits<double>::infinity();
  CHECK(refusal(larger, smaller).find("has not converged") != std::string::npos);
}

TEST_CASE("several independent variances have binomial weights") {
  const data::Table table = lines(0.5);
  const FittedModel none = fitted(table, {}, "");
  const FittedModel both = fitted(table, {}, "a + b | plot", "none", Covariance::kDiagonal);
  CHECK(likelihood_ratio_test(both, none).reference.weights ==
        std::vector<double>{0.25, 0.5, 0.25});
}

TEST_CASE("there is no test, and a reason, where models or data do not allow one") {
  const data::Table table = lines(0.5);
  const FittedModel none = fitted(table, {}, "");
  const FittedModel one = fitted(table, {}, "a | plot");
  const FittedModel on_slope = fitted(table, {}, "b | plot");
  CHECK(refusal(none, one).find("only the smaller model has random effects") != std::string::npos);
  CHECK(refusal(fitted(table, {"a ~ 1 + z"}, "b | plot"), one).find("random effect on a") !=
        std::string::npos);
  CHECK(refusal(on_slope, one).find("only the smaller") != std::string::npos);
  const data::Table other = lines(0.5, 4);
  CHECK(refusal(one, fitted(other, {}, "")).find("different observations") != std::string::npos);
  FitModelOptions laplace;
  laplace.method = Method::kLaplace;
  const FittedModel marginal =
      fitted(table, {"a ~ 1 + z"}, "a | plot", "none", Covariance::kGeneral, laplace);
  CHECK(refusal(marginal, one).find("different approximations") != std::string::npos);
  FitModelOptions restricted;
  restricted.reml = true;
  const FittedModel reml =
      fitted(table, {"a ~ 1 + z"}, "a | plot", "none", Covariance::kGeneral, restricted);
  const FittedModel smaller_reml =
      fitted(table, {}, "a | plot", "none", Covariance::kGeneral, restricted);
  CHECK(refusal(reml, smaller_reml).find("fit both by ML") != std::string::npos);
  CHECK(refusal(reml, one).find("REML") != std::string::npos);
}

TEST_CASE("rows in another order are the same observations") {
  const data::Table table = lines(0.5);
  std::vector<std::size_t> reversed;
  for (std::size_t row = table.rows(); row > 0; --row) reversed.push_back(row - 1);
  const FittedModel forwards = fitted(table, {}, "");
  const FittedModel backwards = fitted(table.select(reversed), {}, "a | plot");
  CHECK(forwards.response_fingerprint == backwards.response_fingerprint);
  CHECK(refusal(backwards, forwards).empty());
}

TEST_CASE("a comparison sorts by parameters and weighs by AIC") {
  const data::Table table = lines(0.5);
  const FittedModel none = fitted(table, {}, "");
  const FittedModel one = fitted(table, {}, "a | plot");
  const FittedModel more = fitted(table, {"a ~ 1 + z"}, "a | plot");
  const Comparison comparison = compare({&more, &none, &one});
  REQUIRE(comparison.fits.size() == 3);
  CHECK(comparison.reason.empty());
  CHECK(comparison.fits[0].fit == &none);
  CHECK(comparison.fits[2].fit == &more);
  double sum = 0.0;
  double smallest = 1e300;
  for (const ComparedFit& row : comparison.fits) {
    sum += row.akaike_weight;
    smallest = std::min(smallest, row.aic_difference);
  }
  CHECK(sum == Approx(1.0).epsilon(1e-12));
  CHECK(smallest == 0.0);
  // Burnham and Anderson 2002, section 2.9: weights are in the ratio exp(-difference/2).
  CHECK(comparison.fits[0].akaike_weight / comparison.fits[1].akaike_weight ==
        Approx(std::exp(-0.5 * (none.aic() - one.aic()))).epsilon(1e-10));
  REQUIRE(comparison.pairs.size() == 2);
  CHECK(comparison.pairs[0].test.has_value());
  CHECK_THROWS_AS(compare({&one}), UsageError);
}

TEST_CASE("a fit with an unknown number of parameters is last and is not tested") {
  const data::Table table = lines(0.5);
  const FittedModel none = fitted(table, {}, "");
  const FittedModel one = fitted(table, {}, "a | plot");
  FittedModel unknown = fitted(table, {"a ~ 1 + z"}, "a | plot");
  unknown.parameter_count = 0;
  const Comparison comparison = compare({&unknown, &none, &one});
  REQUIRE(comparison.fits.size() == 3);
  CHECK(comparison.fits[2].fit == &unknown);
  CHECK(std::isnan(comparison.fits[2].akaike_weight));
  CHECK(comparison.fits[0].akaike_weight + comparison.fits[1].akaike_weight ==
        Approx(1.0).epsilon(1e-12));
  CHECK(comparison.pairs[0].test.has_value());
  CHECK_FALSE(comparison.pairs[1].test.has_value());
  CHECK_THAT(comparison.pairs[1].reason, Contains("unknown"));
}

TEST_CASE("BIC by groups counts independent groups") {
  const FittedModel one = fitted(lines(0.5), {}, "a | plot");
  CHECK(one.bic_groups() ==
        Approx(-2.0 * one.log_likelihood + 4.0 * std::log(kPlots)).epsilon(1e-14));
  CHECK(std::isnan(fitted(lines(0.5), {}, "").bic_groups()));
}
