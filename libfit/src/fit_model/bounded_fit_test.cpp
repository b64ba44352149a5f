// SPDX-License-Identifier: MIT
// Fits with bounds, compared with R and with fits with held values.
#include <catch2/catch.hpp>
#include <cmath>

#include "fit_model/bound_slopes.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

/// Trees whose heights bend so little that no curve has an asymptote to speak of: the free fits run
/// off to 137 m, to negative heights, or on for ever.
const std::vector<double> kDbh{26.8, 38.0, 30.9, 21.3, 38.0, 9.0,  21.4, 25.1, 5.5,  37.1,
                               31.8, 9.9,  26.6, 35.5, 12.3, 35.5, 15.1, 28.7, 12.2, 38.8,
                               36.3, 10.8, 10.1, 26.1, 5.1,  15.8, 33.6, 21.8, 29.7, 5.8,
                               31.2, 32.6, 17.8, 6.6,  11.3, 31.5, 37.5, 17.4, 23.4, 31.2};
const std::vector<double> kHeight{17.288, 22.322, 20.054, 13.966, 22.825, 4.969,  14.167, 17.612,
                                  4.768,  24.352, 21.341, 8.746,  17.302, 22.643, 9.292,  25.376,
                                  11.569, 18.222, 10.048, 24.025, 22.794, 8.683,  8.137,  17.297,
                                  3.963,  9.963,  20.595, 14.485, 21.665, 5.733,  20.127, 20.702,
                                  11.861, 5.196,  8.715,  20.016, 24.659, 11.413, 15.417, 19.548};

data::Table trees() {
  data::Table table;
  table.set("dbh", kDbh);
  table.set("h", kHeight);
  return table;
}

constexpr const char* kLogistic = "h ~ 1.3 + a/(1 + 1/(b*dbh^c))";
constexpr const char* kKorf = "h ~ 1.3 + a*exp(-b*dbh^(-c))";
constexpr const char* kChapmanRichards = "h ~ 1.3 + a*(1 - exp(-b*dbh))^c";

struct PublishedFit {
  const char* formula;
  std::map<std::string, Bounds> bounds;
  Eigen::Vector3d estimate;
  double log_likelihood;
  std::vector<std::string> boundary;
};

/// Heights of eight plots, whose rate b differs, along the curve 1.3 + 80 (1 - exp(-b dbh))^1.1.
data::Table plots() {
  Random random(5);
  std::vector<double> dbh;
  std::vector<double> height;
  data::TextColumn plot;
  for (int g = 0; g < 8; ++g) {
    const double rate = 0.011 + 0.001 * random.normal();
    for (int i = 0; i < 12; ++i) {
      dbh.push_back(random.uniform(6.0, 40.0));
      height.push_back(1.3 + 80.0 * std::pow(1.0 - std::exp(-rate * dbh.back()), 1.1) +
                       0.8 * random.normal());
      plot.append("p" + std::to_string(g));
    }
  }
  data::Table table;
  table.set("plot", plot);
  table.set("dbh", dbh);
  table.set("h", height);
  return table;
}

ModelSpecification mixed_model(const data::Table& table) {
  ModelSpecification model = specify_model(kChapmanRichards, {}, table);
  add_random_effects(model, "b | plot", table);
  return model;
}

}  // namespace

TEST_CASE("bounded least squares are those of R's nls with algorithm port") {
  // R 4, d with the trees above, for instance
  //   nls(h ~ 1.3 + a/(1 + 1/(b*dbh^c)), d, start = c(a = 50, b = 0.02, c = 1.1), algorithm =
  //       "port", lower = c(5, -Inf, -Inf), upper = c(60, Inf, Inf),
  //       control = nls.control(maxiter = 500, tol = 1e-10))
  // and its coef() and logLik(). The last one has its maximum inside; at a = 137 port itself stops
  // six digits before the end.
  const std::vector<PublishedFit> fits{
      {kLogistic,
       {{"a", {5.0, 60.0}}},
       {60.0, 0.00650245686069, 1.24069148655833},
       -55.2424488239,
       {"a = 60, its upper bound"}},
      {kKorf,
       {{"a", {5.0, 60.0}}},
       {60.0, 9.573774284312, 0.616688111429},
       -63.3615568575,
       {"a = 60, its upper bound"}},
      {kChapmanRichards,
       {{"a", {5.0, 60.0}}},
       {60.0, 0.0142205360204, 1.1218746473738},
       -54.1020990076,
       {"a = 60, its upper bound"}},
      // With c at its bound a is inside, although it is outside in the free fit.
      {kChapmanRichards,
       {{"a", {5.0, 60.0}}, {"c", {1.3, 2.0}}},
       {42.2316817904010, 0.0250604796332, 1.3},
       -55.5428693813,
       {"c = 1.3, its lower bound"}},
      {kChapmanRichards,
       {{"a", {5.0, 60.0}}, {"b", {0.02, 0.2}}},
       {47.88793626418, 0.02, 1.20337979115},
       -54.6858232999,
       {"b = 0.02, its lower bound"}},
      {kChapmanRichards,
       {{"a", {5.0, 60.0}}, {"b", {0.02, 0.2}}, {"c", {1.5, 3.0}}},
       {34.571701968522, 0.035973919678, 1.5},
       -57.9477039033,
       {"c = 1.5, its lower bound"}},
      {kLogistic,
       {{"a", {5.0, 60.0}}, {"c", {0.5, 1.2}}},
       {60.0, 0.00744632617898, 1.2},
       -55.7410648546,
       {"a = 60, its upper bound", "c = 1.2, its upper bound"}},
  };
  const data::Table table = trees();
  for (const PublishedFit& expected : fits) {
    INFO(expected.formula);
    const ModelSpecification model = specify_model(expected.formula, {}, table);
    const FittedModel fit = fit_model(model, table, {.bounds = expected.bounds}).fit;
    REQUIRE(fit.convergence.converged());
    CHECK(fit.convergence.boundary() == expected.boundary);
    // Port stops if the sum of squares is constant to ten digits, so that the coefficients have
    // half as many at least.
    CHECK(fit.log_likelihood == Approx(expected.log_likelihood).epsilon(1e-10));
    for (Eigen::Index j = 0; j < 3; ++j) {
      CHECK(fit.estimate[j] == Approx(expected.estimate[j]).epsilon(1e-5));
    }
  }
}

TEST_CASE("a range that is far off neither stops a fit nor is forgotten") {
  // At c = 10,000 the mean is infinite.
  const data::Table table = trees();
  const ModelSpecification model = specify_model(kLogistic, {}, table);
  const FittedModel fit = fit_model(model, table, {.bounds = {{"c", {1.3, 1e4}}}}).fit;
  const FittedModel held = fit_model(model, table, {.fixed = {{"c", 1.3}}}).fit;
  REQUIRE(fit.convergence.converged());
  CHECK(fit.log_likelihood == held.log_likelihood);
  CHECK_THAT(fit.convergence.verdict(), Contains("c = 1.3, its lower bound"));
}

TEST_CASE("a maximum within the bounds is found if the unbounded maximum is outside") {
  // sin(b x) has many frequencies that nearly fit; that of the data is 2.
  Random random(8);
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 40; ++i) {
    x.push_back(0.25 * i);
    y.push_back(std::sin(2.0 * x.back()) + 0.5 * std::sin(1.0 * x.back()) + 0.1 * random.normal());
  }
  data::Table table;
  table.set("x", x);
  table.set("y", y);
  const ModelSpecification model = specify_model("y ~ a*sin(b*x)", {}, table);
  const FittedModel fit = fit_model(model, table, {.bounds = {{"b", {0.8, 1.2}}}}).fit;
  REQUIRE(fit.convergence.converged());
  CHECK(!fit.convergence.has_boundary());
  double highest = -kInfinity;
  for (int k = 0; k <= 400; ++k) {
    const double b = 0.8 + 0.001 * k;
    const FittedModel held = fit_model(model, table, {.fixed = {{"b", b}}}).fit;
    highest = std::max(highest, held.log_likelihood);
  }
  CHECK(fit.log_likelihood >= highest);
  // A grid of 0.001 is a hundredth of a standard error wide.
  CHECK(fit.log_likelihood == Approx(highest).margin(1e-3));
}

TEST_CASE("a fit whose maximum is at infinity has not converged with a bound on the near side") {
  const data::Table table = trees();
  // These heights are convex, but 1 - exp(-b dbh) is concave: a straight line is nearest.
  std::vector<double> height;
  height.reserve(kDbh.size());
  for (const double dbh : kDbh) height.push_back(1.3 + 0.5 * dbh + 0.002 * dbh * dbh);
  data::Table bent = table;
  bent.set("h", height);
  const ModelSpecification model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, bent);
  const FittedModel open = fit_model(model, bent, {.bounds = {{"a", {5.0, kInfinity}}}}).fit;
  CHECK(!open.convergence.converged());
  const FittedModel closed = fit_model(model, bent, {.bounds = {{"a", {5.0, 1000.0}}}}).fit;
  REQUIRE(closed.convergence.converged());
  CHECK(closed.estimate[0] == 1000.0);
}

TEST_CASE("a bounded fit is not below a model that its curve approaches within the bounds") {
  // V x/(K + x) with large K is the line b x with b = V/K, also with effects of groups.
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    silvafit::Random random(seed);
    data::TextColumn group;
    std::vector<double> x;
    std::vector<double> y;
    for (int g = 0; g < 8; ++g) {
      const double slope = 2.0 + 0.3 * random.normal();
      for (int i = 0; i < 8; ++i) {
        group.append(std::to_string(g));
        x.push_back(random.uniform(0.5, 5.0));
        y.push_back(slope * x.back() + 0.3 * random.normal());
      }
    }
    data::Table table;
    table.set("g", group);
    table.set("x", x);
    table.set("y", y);
    const auto fitted = [&table](const char* formula,
                                 const char* effects,
                                 const std::map<std::string, Bounds>& bounds) {
      ModelSpecification model = specify_model(formula, {}, table);
      add_random_effects(model, effects, table);
      return fit_model(model, table, {.method = Method::kInteraction, .bounds = bounds}).fit;
    };
    const FittedModel line = fitted("y ~ b*x", "b | g", {});
    const FittedModel curve =
        fitted("y ~ V*x/(K + x)", "V + K | g", {{"K", {0.0, silvafit::kInfinity}}});
    REQUIRE(line.convergence.converged());
    INFO(seed << " " << curve.log_likelihood << " " << line.log_likelihood);
    CHECK((!curve.convergence.converged() || curve.log_likelihood > line.log_likelihood - 1e-3));
  }
}

TEST_CASE("generalized least squares are at the bound if the likelihood decreases inwards") {
  const data::Table table = trees();
  ModelSpecification model = specify_model(kChapmanRichards, {}, table);
  model.variance = parse_variance_function("power");
  for (const bool reml : {false, true}) {
    const FittedModel fit =
        fit_model(model, table, {.bounds = {{"a", {5.0, 60.0}}}, .reml = reml}).fit;
    const FittedModel held = fit_model(model, table, {.fixed = {{"a", 60.0}}, .reml = reml}).fit;
    REQUIRE(fit.convergence.converged());
    CHECK(fit.estimate[0] == 60.0);
    CHECK(fit.log_likelihood == held.log_likelihood);
    CHECK(fit.parameter_count == held.parameter_count + 1);
    const FittedModel inside = fit_model(model, table, {.fixed = {{"a", 59.0}}, .reml = false}).fit;
    const FittedModel at = fit_model(model, table, {.fixed = {{"a", 60.0}}, .reml = false}).fit;
    CHECK(inside.log_likelihood < at.log_likelihood);
  }
}

TEST_CASE("a bounded fit by restricted likelihood does not depend on the unit of the response") {
  // With b = 0 delta and sigma are one, so that this set of the search has not converged; its
  // restricted likelihood has other coefficients and another unit than that of the others.
  Random random(3);
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 120; ++i) {
    x.push_back(i / 6.0);
    y.push_back(20.0 + 0.06 * x.back() + random.normal());
  }
  for (const double unit : {1.0, 1e4, 1e-4}) {
    data::Table table;
    std::vector<double> scaled;
    scaled.reserve(y.size());
    for (const double value : y) scaled.push_back(unit * value);
    table.set("x", x);
    table.set("y", scaled);
    ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
    model.variance = parse_variance_function("power");
    const FittedModel fit =
        fit_model(model, table, {.bounds = {{"b", {0.0, 0.03 * unit}}}, .reml = true}).fit;
    INFO(unit << ": " << fit.convergence.verdict());
    CHECK(fit.convergence.converged());
    CHECK(fit.estimate[1] == 0.03 * unit);
  }
}

TEST_CASE("a bound at which the formula is undefined does not prevent a fit") {
  Random random(8);
  std::vector<double> d;
  std::vector<double> y;
  for (int i = 0; i < 60; ++i) {
    d.push_back(4.0 + 0.5 * i);
    y.push_back(3.0 + 3.0 * std::log(d.back() + 1.0) + 0.1 * random.normal());
  }
  data::Table table;
  table.set("d", d);
  table.set("y", y);
  // log(d - 5) does not exist for the first two rows.
  const FittedModel fit = fit_model(specify_model("y ~ a + b*log(d - c)", {}, table),
                                    table,
                                    {.bounds = {{"c", {5.0, 100.0}}}})
                              .fit;
  CHECK_FALSE(fit.convergence.converged());
  CHECK_THAT(fit.convergence.verdict(), Catch::Contains("The fit without bounds is shown"));
  CHECK(fit.estimate[2] == Approx(-1.0).margin(1.0));
}

TEST_CASE("mixed fits of all methods are at the bound if the likelihood decreases inwards") {
  const data::Table table = plots();
  const ModelSpecification model = mixed_model(table);
  for (const Method method : {Method::kLindstromBates,
                              Method::kLaplace,
                              Method::kQuadrature,
                              Method::kFirstOrder,
                              Method::kInteraction}) {
    INFO(word_of(method));
    const auto fitted = [&](const std::map<std::string, double>& fixed,
                            const std::map<std::string, Bounds>& bounds) {
      return fit_model(model,
                       table,
                       {.method = method, .fixed = fixed, .bounds = bounds, .quadrature_points = 3})
          .fit;
    };
    const FittedModel fit = fitted({}, {{"a", {5.0, 50.0}}});
    const FittedModel held = fitted({{"a", 50.0}}, {});
    REQUIRE(fit.convergence.converged());
    CHECK(fit.estimate[0] == 50.0);
    CHECK(fit.log_likelihood == held.log_likelihood);
    CHECK(fit.parameter_count == held.parameter_count + 1);
    CHECK_THAT(fit.convergence.verdict(), Contains("a = 50, its upper bound"));

    // The slope by differences of fits with a held. Linear around its own estimates, the model of
    // lb is another one at each a, so that its slope is only like that.
    const double step = 0.05;
    const double rise = (fitted({{"a", 50.0 + step}}, {}).log_likelihood -
                         fitted({{"a", 50.0 - step}}, {}).log_likelihood) /
                        (2.0 * step);
    const HeldPoint point = at_held(fit, table, {}, {{"a", 50.0}});
    CHECK(rise > 0.0);
    CHECK(point.slopes.at("a") > 0.0);
    CHECK(point.value == fit.log_likelihood);
  }
}

TEST_CASE("the slope at a held value is that of the profile likelihood") {
  const data::Table table = trees();
  const ModelSpecification model = specify_model(kChapmanRichards, {}, table);
  const auto held = [&](double a) { return fit_model(model, table, {.fixed = {{"a", a}}}).fit; };
  const FittedModel fit = held(60.0);
  const double slope = at_held(fit, table, {}, {{"a", 60.0}}).slopes.at("a");
  const double rise = (held(60.01).log_likelihood - held(59.99).log_likelihood) / 0.02;
  // The slope is one a standard error of a alone: sigma over the length of the mean's derivative
  // (1 - exp(-b dbh))^c, with n in the denominator of sigma.
  double squares = 0.0;
  for (const double dbh : kDbh) {
    squares += std::pow(1.0 - std::exp(-fit.estimate[1] * dbh), 2.0 * fit.estimate[2]);
  }
  const double sigma = fit.sigma * std::sqrt((40.0 - 2.0) / 40.0);
  // Differences of log-likelihoods of 1e-13 each over 0.02, and of the second order.
  CHECK(slope == Approx(rise * sigma / std::sqrt(squares)).epsilon(1e-5));
}

TEST_CASE("an optimum at the edge of the domain is found where the slope is infinite") {
  // The root has an infinite slope at d + c = 0. The responses at d = 0 are below the line through
  // the others, so that c = 0 is best, where y is linear in sqrt(d): the normal equations by hand.
  const std::vector<double> d{0, 0, 1, 1, 4, 4, 9, 9};
  const std::vector<double> y{-1.2, -0.7, 10.3, 9.6, 20.4, 19.9, 30.2, 29.5};
  data::Table table;
  table.set("d", d);
  table.set("y", y);
  double sy = 0.0;
  double sxy = 0.0;
  for (std::size_t i = 0; i < d.size(); ++i) {
    sy += y[i];
    sxy += std::sqrt(d[i]) * y[i];
  }
  constexpr double kN = 8.0;
  constexpr double kSx = 12.0;
  constexpr double kSxx = 28.0;
  const double slope = (kN * sxy - kSx * sy) / (kN * kSxx - kSx * kSx);
  FitModelOptions options;
  options.bounds = {{"c", {.low = 0.0, .high = kInfinity}}};
  const FittedModel fit =
      fit_model(specify_model("y ~ a + b*sqrt(d + c)", {}, table), table, options).fit;
  INFO(fit.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  CHECK(fit.estimate[2] == 0.0);
  CHECK(fit.estimate[1] == Approx(slope).epsilon(1e-9));
  CHECK(fit.estimate[0] == Approx((sy - slope * kSx) / kN).margin(1e-8));
  CHECK_THAT(fit.convergence.verdict(), Contains("c = 0, its lower bound"));
}

TEST_CASE("bounds may hold all coefficients of a mixed model") {
  // The curve is 20 x^1.8/(8^1.8 + x^1.8), which all bounds exclude, so that no coefficient is free
  // and the rest is the fit with all three held. A search far outwards finds no value there.
  Random random(8);
  std::vector<double> x;
  std::vector<double> y;
  data::TextColumn group;
  for (int g = 0; g < 8; ++g) {
    const double asymptote = 20.0 + 2.0 * random.normal();
    for (int i = 0; i < 8; ++i) {
      x.push_back(random.uniform(0.5, 30.0));
      const double power = std::pow(x.back() / 8.0, 1.8);
      y.push_back(asymptote * power / (1.0 + power) + 0.6 * random.normal());
      group.append("g" + std::to_string(g));
    }
  }
  data::Table table;
  table.set("x", x);
  table.set("y", y);
  table.set("g", group);
  const ModelSpecification model =
      specify_model({.formula = "y ~ V*x^n/(K^n + x^n)", .random = "V | g"}, table);
  const std::map<std::string, double> ends{{"V", 26.0}, {"n", 2.4}, {"K", 11.0}};
  FitModelOptions options;
  for (const auto& [name, value] : ends) options.bounds[name] = {.low = value};
  for (const Method method :
       {Method::kLindstromBates, Method::kLaplace, Method::kInteraction, Method::kQuadrature}) {
    options.method = method;
    const FittedModel fit = fit_model(model, table, options).fit;
    INFO(word_of(method) << ": " << fit.convergence.verdict());
    REQUIRE(fit.convergence.converged());
    const FittedModel held = fit_model(model, table, {.method = method, .fixed = ends}).fit;
    // At least as high as at the corner.
    CHECK(fit.log_likelihood >= held.log_likelihood - 1e-6);
    for (std::size_t j = 0; j < fit.coefficient_names.size(); ++j) {
      CHECK(fit.estimate[static_cast<Eigen::Index>(j)] >= ends.at(fit.coefficient_names[j]));
    }
  }
}

TEST_CASE("a maximum with exchanged asymptotes is found beside a coefficient at its bound") {
  // The free fit rises from A to B; within the bounds it falls from A = 27.76 to B = 4.43 at the
  // bound of m, with s = -3.87: least_squares of scipy with all coefficients but m, and n log(2 pi
  // S/n) + n.
  data::Table table;
  table.set("x", std::vector<double>{23.78, 10.72, 23.44, 23.44, 20.76, 12.63, 25.44, 4.63,  29.04,
                                     3.99,  28.82, 27.14, 18.68, 2.71,  5.51,  15.7,  6.21,  26.05,
                                     4.73,  10.77, 18.39, 21.33, 17.01, 6.9,   6.49,  28.6,  28.05,
                                     12.05, 24.41, 22.42, 14.21, 29.25, 27.83, 26.68, 6.12,  1.05,
                                     14.03, 19.82, 3.9,   19.41, 25.88, 12.39, 7.5,   23.62, 29.92,
                                     1.11,  19.64, 20.63, 24.38, 18.39, 0.99,  9.13,  11.2,  20.03,
                                     11.97, 6.25,  9.24,  1.81,  11.8,  19.18});
  table.set("y", std::vector<double>{24.6792, 7.6733,  23.4165, 23.9348, 22.1221, 11.0983, 24.6841,
                                     4.3412,  24.03,   3.579,   23.9318, 24.962,  20.1142, 3.5008,
                                     5.4564,  16.0892, 4.8201,  25.8127, 3.1466,  8.6118,  18.9796,
                                     23.2181, 18.4582, 5.265,   4.4376,  25.1316, 24.2816, 10.538,
                                     24.161,  23.6557, 13.27,   26.0184, 24.6181, 24.1739, 5.5085,
                                     2.6406,  12.0609, 22.7206, 4.8975,  20.9248, 25.5299, 11.0129,
                                     5.5249,  23.9517, 26.0568, 4.6624,  21.312,  21.7342, 24.2817,
                                     19.4883, 4.7347,  6.0308,  8.1895,  20.9695, 9.8953,  5.1533,
                                     6.9455,  4.6,     9.6401,  20.9174});
  FitModelOptions options;
  options.bounds = {{"m", {.low = 17.25}}, {"B", {.low = -1000.0, .high = 21.25}}};
  const FittedModel fit =
      fit_model(specify_model("y ~ A + (B - A)/(1 + exp((m - x)/s))", {}, table), table, options)
          .fit;
  INFO(fit.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  // The published digits.
  CHECK(fit.log_likelihood == Approx(-101.474).margin(5e-4));
}

TEST_CASE("at a bound the errors of the others are those with the coefficient held") {
  // The ages end long before the asymptote, so that the rate is known far better with it held.
  Random random(11);
  data::Table table;
  data::TextColumn group;
  std::vector<double> age;
  std::vector<double> v;
  for (int g = 0; g < 10; ++g) {
    const double limit = 600.0 + random.normal(0.0, 50.0);
    for (int i = 1; i <= 7; ++i) {
      age.push_back(8.0 * i);
      v.push_back(limit * std::exp(-4.0 * std::exp(-0.03 * age.back())) + random.normal(0.0, 4.0));
      group.append(std::to_string(g));
    }
  }
  table.set("age", age);
  table.set("v", v);
  table.set("g", group);
  const ModelSpecification model =
      specify_model({.formula = "v ~ A*exp(-b*exp(-k*age))", .random = "A | g"}, table);
  for (const Method method : {Method::kLindstromBates, Method::kInteraction}) {
    INFO(word_of(method));
    const FittedModel bounded =
        fit_model(model, table, {.method = method, .bounds = {{"A", {.high = 420.0}}}}).fit;
    const FittedModel held =
        fit_model(model, table, {.method = method, .fixed = {{"A", 420.0}}}).fit;
    REQUIRE(bounded.convergence.has(Evidence::Kind::kUpperBound, "A"));
    CHECK(std::isnan(bounded.standard_errors()[0]));
    CHECK(bounded.standard_errors()[1] == Approx(held.standard_errors()[1]).epsilon(1e-3));
    CHECK(bounded.standard_errors()[2] == Approx(held.standard_errors()[2]).epsilon(1e-3));
  }
}
