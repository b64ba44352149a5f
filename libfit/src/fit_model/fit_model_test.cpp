// SPDX-License-Identifier: MIT
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

/// Heights of ten trees of a straight line, worked by hand: x = 1..10, y = 2 + 3 x +- 1.
data::Table line_with_errors() {
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 1; i <= 10; ++i) {
    x.push_back(i);
    y.push_back(2.0 + 3.0 * i + (i % 2 == 0 ? 1.0 : -1.0));
  }
  data::Table table;
  table.set("x", x);
  table.set("y", y);
  return table;
}

/// Twelve animals, each with two of seven doses, whose effects follow an Emax curve of their own:
/// so few data that Lindstrom and Bates' method often has no fixed point.
data::Table two_doses_each(std::uint64_t seed) {
  constexpr double kDoses[] = {0.0, 10.0, 20.0, 50.0, 100.0, 200.0, 300.0};
  Random random(seed);
  std::vector<double> dose;
  std::vector<double> y;
  data::TextColumn group;
  for (int animal = 0; animal < 12; ++animal) {
    const double base = std::exp(1.0 + 0.3 * random.normal());
    const double most = std::exp(4.5 + 0.4 * random.normal());
    const double half = std::exp(3.0 + 0.6 * random.normal());
    for (int k = 0; k < 2; ++k) {
      dose.push_back(kDoses[static_cast<int>(7.0 * random.uniform())]);
      y.push_back(base + most * dose.back() / (half + dose.back()) + 3.0 * random.normal());
      group.append("a" + std::to_string(animal));
    }
  }
  data::Table table;
  table.set("dose", dose);
  table.set("y", y);
  table.set("animal", group);
  return table;
}

}  // namespace

TEST_CASE("a straight line by least squares has the estimates of the normal equations") {
  // With errors e = -1, 1, ...: Sxx = 82.5, sum (x - 5.5) e = 5, mean e = 0, so that the slope is
  // 3 + 5/82.5, the intercept 2 - 5.5 * 5/82.5, and SSE = 10 - 5^2/82.5.
  const data::Table table = line_with_errors();
  const FitResult result = fit_model(specify_model("y ~ a + b*x", {}, table), table);
  const FittedModel& fit = result.fit;
  REQUIRE(fit.convergence.converged());
  CHECK(fit.method == Method::kOrdinary);
  CHECK(fit.observations == 10);
  CHECK(fit.degrees_of_freedom == Eigen::Vector2d(8.0, 8.0));
  CHECK(fit.estimate[0] == Approx(2.0 - 5.5 * 5.0 / 82.5).epsilon(1e-12));
  CHECK(fit.estimate[1] == Approx(3.0 + 5.0 / 82.5).epsilon(1e-12));
  const double sum_of_squares = 10.0 - 25.0 / 82.5;
  const double sigma = std::sqrt(sum_of_squares / 8.0);
  CHECK(fit.sigma == Approx(sigma).epsilon(1e-12));
  CHECK(fit.standard_errors()[1] == Approx(sigma / std::sqrt(82.5)).epsilon(1e-12));
  CHECK(fit.t_values()[1] == Approx(fit.estimate[1] * std::sqrt(82.5) / sigma).epsilon(1e-12));
  CHECK(fit.population.mean_error == Approx(0.0).margin(1e-12));
  CHECK(fit.population.rmse == Approx(std::sqrt(sum_of_squares / 9.0)).epsilon(1e-12));
  CHECK(result.residual_sd[3] == fit.sigma);
  REQUIRE(fit.ranges.size() == 1);
  CHECK(fit.ranges[0].column == "x");
  CHECK(fit.ranges[0].low == 1.0);
  CHECK(fit.ranges[0].high == 10.0);
}

TEST_CASE("p-values are those of Student's t, two-sided") {
  FittedModel fit({.formula = data::parse_formula("y ~ a + b + c + d")});
  fit.estimate = Eigen::Vector4d(2.5, -12.5, 0.0, NAN);
  fit.covariance = Eigen::Matrix4d::Identity();
  // Closed forms: 1 - 2 atan(|t|)/pi with one degree of freedom, 1 - |t|/sqrt(2 + t^2) with two.
  fit.degrees_of_freedom.setConstant(4, 1.0);
  CHECK(fit.p_values()[0] == Approx(1.0 - 2.0 * std::atan(2.5) / std::numbers::pi).epsilon(1e-13));
  CHECK(fit.p_values()[1] == Approx(1.0 - 2.0 * std::atan(12.5) / std::numbers::pi).epsilon(1e-13));
  fit.degrees_of_freedom.setConstant(2.0);
  CHECK(fit.p_values()[0] == Approx(1.0 - 2.5 / std::sqrt(8.25)).epsilon(1e-13));
  CHECK(fit.p_values()[2] == 1.0);
  CHECK(std::isnan(fit.p_values()[3]));
  fit.degrees_of_freedom.setZero();
  CHECK(std::isnan(fit.p_values()[0]));
}

TEST_CASE("residual standard deviations follow nlme's variance functions") {
  FittedModel fit({.formula = data::parse_formula("y ~ a*x")});
  fit.sigma = 2.0;
  const Eigen::Vector3d v(4.0, -4.0, NAN);
  data::Table table(3);
  const auto sd = [&](const char* function, double delta, double constant) {
    fit.variance = VarianceEstimate::missing(parse_variance_function(function));
    for (VarianceFactorEstimate& factor : fit.variance.factors) {
      factor.delta.setConstant(delta);
      factor.constant.setConstant(constant);
    }
    return fit.residual_sd(v, table);
  };
  CHECK(sd("none", 0.0, 0.0)[0] == 2.0);
  CHECK(std::isnan(sd("none", 0.0, 0.0)[2]));
  CHECK(sd("power", 0.5, 0.0)[1] == Approx(4.0).epsilon(1e-15));
  CHECK(sd("exponential", 0.25, 0.0)[1] == Approx(2.0 * std::exp(-1.0)).epsilon(1e-15));
  CHECK(sd("constant-plus-power", 0.5, 1.5)[0] == Approx(7.0).epsilon(1e-15));
  CHECK(sd("constant-plus-power", 0.5, INFINITY)[0] == 2.0);
}

TEST_CASE("residual standard deviations by stratum are those of the row's stratum") {
  FittedModel fit({.formula = data::parse_formula("y ~ a*x")});
  fit.sigma = 2.0;
  data::Table table(3);
  data::TextColumn species;
  for (const char* const label : {"oak", "fir", "elm"}) species.append(label);
  table.set("species", species);
  fit.variance = VarianceEstimate::missing(parse_variance_function("power(fitted | species)"));
  fit.variance.factors[0].strata = {"fir", "oak"};
  fit.variance.factors[0].delta = Eigen::Vector2d(0.5, 1.0);
  const Eigen::VectorXd sd = fit.residual_sd(Eigen::Vector3d(4.0, 4.0, 4.0), table);
  CHECK(sd[0] == Approx(8.0).epsilon(1e-15));
  CHECK(sd[1] == Approx(4.0).epsilon(1e-15));
  CHECK(std::isnan(sd[2]));  // elm is unknown
}

TEST_CASE("the method has to suit the model") {
  const data::Table table = line_with_errors();
  ModelSpecification specification = specify_model("y ~ a + b*x", {}, table);
  CHECK(default_method(specification) == Method::kOrdinary);
  CHECK_THROWS_WITH(fit_model(specification, table, {.method = Method::kLindstromBates}),
                    Contains("needs random effects"));
  // Of a line, REML is sigma^2 = RSS/(N - 2), as least squares have it.
  const FittedModel restricted = fit_model(specification, table, {.reml = true}).fit;
  CHECK(restricted.method == Method::kGeneralized);
  CHECK(restricted.reml);
  CHECK(restricted.sigma == Approx(fit_model(specification, table).fit.sigma).epsilon(1e-9));
  specification.variance = parse_variance_function("power");
  CHECK(default_method(specification) == Method::kGeneralized);
  CHECK_THROWS_AS(fit_model(specification, table, {.method = Method::kOrdinary}), UsageError);
  CHECK_THROWS_WITH(fit_model(specification, table, {.start = {{"q", 1.0}}}),
                    Contains("unknown coefficient 'q'"));
  CHECK_THROWS_WITH(value_of<Method>("reml", "method"), Contains("available: ols, gnls, lb"));
  data::Table plots = table;
  plots.set("plot", std::vector<double>{1, 1, 1, 1, 1, 2, 2, 2, 2, 2});
  ModelSpecification mixed = specify_model("y ~ a + b*x + c*x^2", {}, plots);
  add_random_effects(mixed, "a + b + c | plot", plots);
  // 27^3 = 19,683 and 28^3 = 21,952
  CHECK_THROWS_WITH(
      fit_model(mixed, plots, {.method = Method::kQuadrature, .quadrature_points = 28}),
      Contains("the limit is 20000, 27 per random effect"));
  for (const char* name : {"ols", "gnls", "lb"})
    CHECK(word_of(value_of<Method>(name, "method")) == name);
}

TEST_CASE("a fit without possible start values has a message with the reason") {
  data::Table table;
  table.set("x", std::vector<double>{1.0, 2.0});
  table.set("y", std::vector<double>{1.0, 3.0});
  table.set("g", std::vector<double>{1.0, 2.0});
  ModelSpecification specification = specify_model("y ~ a + b*x + c*x^2", {}, table);
  add_random_effects(specification, "a | g", table);
  const FitResult result = fit_model(specification, table);
  CHECK_FALSE(result.fit.convergence.converged());
  CHECK_THAT(result.fit.convergence.verdict(),
             Contains("3 coefficients need at least as many observations, but there are 2"));
  CHECK(std::isnan(result.fit.log_likelihood));
  CHECK(result.fit.random.back().effects.cols() == 2);
}

TEST_CASE("a held exponent that suits the data badly is weighted least squares all the same") {
  // Residuals of one size, weights of 1/x: the log-likelihood is below that of equal weights, and
  // is -n/2 (log(2 pi S/n) + 1) - sum(log x)/2 with S the least sum of (y - b x)^2 / x.
  data::Table table;
  std::vector<double> x;
  std::vector<double> y;
  double sum_x = 0.0;
  double sum_y = 0.0;
  double squares = 0.0;
  double logs = 0.0;
  constexpr int kRows = 40;
  for (int i = 1; i <= kRows; ++i) {
    x.push_back(i);
    y.push_back(3.0 * i + (i % 2 == 0 ? 1.0 : -1.0));
    sum_x += x.back();
    sum_y += y.back();
    squares += y.back() * y.back() / x.back();
    logs += std::log(x.back());
  }
  table.set("x", x);
  table.set("y", y);
  ModelSpecification model = specify_model("y ~ b*x", {}, table);
  const FittedModel equal = fit_model(model, table).fit;
  model.variance = parse_variance_function("power(x, delta = 0.5)");
  const FittedModel fit = fit_model(model, table).fit;
  INFO(fit.convergence.verdict());
  CHECK(fit.convergence.converged());
  CHECK(fit.estimate[0] == Approx(sum_y / sum_x).epsilon(1e-12));
  const double least = squares - sum_y * sum_y / sum_x;
  const double expected =
      -0.5 * kRows * (std::log(2.0 * std::numbers::pi * least / kRows) + 1.0) - 0.5 * logs;
  CHECK(fit.log_likelihood == Approx(expected).epsilon(1e-12));
  CHECK(fit.log_likelihood < equal.log_likelihood);
}

TEST_CASE("where lb finds no result and was not asked for, focei is tried") {
  int replaced = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    CAPTURE(seed);
    const data::Table table = two_doses_each(seed);
    const ModelSpecification emax =
        specify_model({.formula = "y ~ exp(lE) + exp(lM)*dose/(exp(lD) + dose)",
                       .random = "lE + lM + lD | animal"},
                      table);
    const FittedModel usual = fit_model(emax, table).fit;
    const FittedModel lb = fit_model(emax, table, {.method = Method::kLindstromBates}).fit;
    if (usual.method == Method::kLindstromBates) {
      CHECK(usual.convergence.verdict() == lb.convergence.verdict());
      continue;
    }
    ++replaced;
    CHECK_FALSE(lb.convergence.converged());
    CHECK(usual.convergence.converged());
    CHECK_THAT(usual.convergence.verdict(),
               Contains("Fitted by focei, because lb found no result"));
    const FittedModel focei = fit_model(emax, table, {.method = Method::kInteraction}).fit;
    CHECK(usual.log_likelihood == focei.log_likelihood);
  }
  CHECK(replaced > 0);
}

TEST_CASE("a row whose residual variance is 0 or infinite by a column is an error") {
  data::Table table;
  table.set("x", std::vector<double>{1.0, 2.0, 3.0, 4.0, 5.0, 6.0});
  table.set("y", std::vector<double>{1.1, 1.9, 3.2, 3.8, 5.1, 6.2});
  table.set("w", std::vector<double>{1.0, 2.0, 0.0, 1.5, 1.0, 3.0});
  for (const char* const variance : {"power(w, delta = 0.5)",
                                     "power(w, delta = -0.5)",
                                     "power(w)",
                                     "constant-plus-power(w, delta = -1)"}) {
    const ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
    ModelSpecification weighted = model;
    weighted.variance = parse_variance_function(variance);
    INFO(variance);
    CHECK_THROWS_WITH(fit_model(weighted, table),
                      Catch::Matchers::Contains("w") && Catch::Matchers::Contains("is 0"));
  }
  // Of these g is positive at 0.
  for (const char* const variance : {"power(w, delta = 0)", "exponential(w, delta = 1)"}) {
    ModelSpecification weighted = specify_model("y ~ a + b*x", {}, table);
    weighted.variance = parse_variance_function(variance);
    CHECK_NOTHROW(fit_model(weighted, table));
  }
}
