// SPDX-License-Identifier: MIT
#include "silvafit/fit/intervals.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "inference/information.hpp"
#include "inference/natural_parameters.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/fitted_model.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Growth curves whose limit and rate differ by plot, of two species in two stands.
data::Table curves(int plots = 16, int trees = 12) {
  Random random(11);
  data::Table table;
  data::TextColumn plot;
  data::TextColumn stand;
  data::TextColumn species;
  std::vector<double> dbh;
  std::vector<double> h;
  for (int i = 0; i < plots; ++i) {
    const double limit = 25.0 + random.normal(0.0, 3.0);
    const double rate = 0.06 * std::exp(random.normal(0.0, 0.2));
    for (int j = 0; j < trees; ++j) {
      dbh.push_back(random.uniform(5.0, 40.0));
      const double mean = 1.3 + limit * (1.0 - std::exp(-rate * dbh.back()));
      const bool is_oak = j % 2 == 1;
      h.push_back(mean + random.normal(0.0, (is_oak ? 0.15 : 0.1) * mean));
      plot.append("p" + std::to_string(i));
      stand.append("s" + std::to_string(i / 4));
      species.append(is_oak ? "oak" : "fir");
    }
  }
  table.set("dbh", dbh);
  table.set("h", h);
  table.set("plot", plot);
  table.set("stand", stand);
  table.set("species", species);
  return table;
}

FittedModel fitted_by_method(const data::Table& table,
                             const char* random,
                             const char* variance,
                             const char* method,
                             Covariance covariance = Covariance::kGeneral) {
  ModelSpecification model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table);
  if (*random != '\0') add_random_effects(model, random, table);
  for (RandomEffects& term : model.random) term.covariance = covariance;
  model.variance = parse_variance_function(variance);
  FitModelOptions options;
  options.method = value_of<Method>(method, "method");
  return fit_model(model, table, options).fit;
}

/// Checks gradients of a surface, alone and with each parameter held, against differences.
void check_gradients(const FittedModel& fit, const data::Table& table) {
  const SurfaceSetting setting(fit, table);
  const auto surface = make_surface(setting);
  const SurfaceLayout& layout = surface->layout();
  VectorXd x = surface->optimum();
  // At the maximum the likelihood is that of the fit.
  CHECK(-surface->value(x, nullptr) == Approx(fit.log_likelihood).epsilon(1e-8));
  Random random(5);
  for (double& value : x) value += 0.02 * random.normal();
  const auto difference = [&](const auto& function, Index k) {
    constexpr double kStep = 1e-4;
    VectorXd above = x;
    VectorXd below = x;
    above[k] += kStep;
    below[k] -= kStep;
    return (function(above) - function(below)) / (2.0 * kStep);
  };
  const auto check = [&](const VectorXd& gradient, const auto& function) {
    for (Index k = 0; k < x.size(); ++k) {
      // Modes are searched to 1e-9 standard deviations, which is as much in the value of Laplace's
      // method, and 1e-5 in a difference over 2e-4.
      CHECK(gradient[k] ==
            Approx(difference(function, k)).epsilon(1e-4).margin(2e-5 * (1.0 + gradient.norm())));
    }
  };
  VectorXd gradient(x.size());
  surface->value(x, &gradient);
  check(gradient, [&](const VectorXd& at) { return surface->value(at, nullptr); });
  for (const NaturalParameter& parameter : natural_parameters(setting, layout)) {
    INFO(parameter.name);
    const double share = parameter.kind == ParameterKind::kCorrelation ? 0.9 : 1.05;
    const double value = share * parameter.value(layout, setting.variance, x);
    const VectorXd held = parameter.hold(layout, setting.variance, x, value);
    CHECK(parameter.value(layout, setting.variance, held) == Approx(value).epsilon(1e-10));
    surface->value(held, &gradient);
    check(parameter.pull_back(layout, setting.variance, x, value, gradient),
          [&](const VectorXd& at) {
            return surface->value(parameter.hold(layout, setting.variance, at, value), nullptr);
          });
  }
}

}  // namespace

TEST_CASE("likelihoods of intervals have exact gradients, with any parameter held") {
  const data::Table table = curves();
  const auto check = [&](const char* random,
                         const char* variance,
                         const char* method,
                         Covariance covariance = Covariance::kGeneral) {
    INFO(method << ", " << random << ", " << variance);
    const FittedModel fit = fitted_by_method(table, random, variance, method, covariance);
    INFO(fit.convergence.verdict());
    REQUIRE(fit.convergence.converged());
    check_gradients(fit, table);
  };
  check("a + b | plot", "power", "laplace");
  check("a + b | plot", "exponential", "lb");
  check("a + b | plot", "stratum(species)", "lb", Covariance::kDiagonal);
  check("a + b | plot", "power", "focei", Covariance::kDiagonal);
  check("a + b | plot", "none", "lb", Covariance::kIdentity);
  check("a + b | plot", "none", "lb", Covariance::kCompoundSymmetry);
  check("a + b | plot", "power", "laplace", Covariance::kCompoundSymmetry);
  check("a | stand; a + b | plot", "power(dbh)", "lb", Covariance::kDiagonal);
  check("", "stratum(species) * power(dbh)", "gnls");
  check("", "power", "gnls");
}

TEST_CASE("profile intervals of a straight line are those of Student's t") {
  // Where the mean is linear the sum of squares is a parabola, and the interval that of the t test.
  Random random(2);
  data::Table table;
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 15; ++i) {
    x.push_back(i);
    y.push_back(3.0 + 0.5 * i + random.normal());
  }
  table.set("x", x);
  table.set("y", y);
  const FittedModel fit = fit_model(specify_model("y ~ a + b*x", {}, table), table).fit;
  for (const double level : {0.5, 0.9, 0.99}) {
    const Intervals profile =
        confidence_intervals(fit, table, {.method = IntervalMethod::kProfile, .level = level});
    const double t = boost::math::quantile(boost::math::students_t(13.0), 0.5 + 0.5 * level);
    for (Index j = 0; j < 2; ++j) {
      const double reach = t * fit.standard_errors()[j];
      const ParameterInterval& interval = profile.parameters[static_cast<std::size_t>(j)];
      // Limits are roots to 1e-6 of the distance.
      CHECK(interval.lower == Approx(fit.estimate[j] - reach).margin(1e-5 * reach));
      CHECK(interval.upper == Approx(fit.estimate[j] + reach).margin(1e-5 * reach));
    }
  }
}

TEST_CASE("profiles follow a ridge through infinity to the other side") {
  data::Table table;
  std::vector<double> x;
  for (int i = 0; i < 24; ++i) x.push_back(i % 12 + 1);
  table.set("x", x);
  table.set("y", {2.74, 2.57, 3.4,  4.25, 4.31, 4.82, 6.19, 6.67, 7.94, 8.51, 10.52, 11.65,
                  2.23, 3.13, 3.72, 3.66, 4.35, 5.41, 5.61, 6.85, 7.4,  9.21, 10.28, 11.66});
  table.set("z", {3.21, 4.21, 5.85, 7.29, 7.76, 8.51, 9.97, 10.38, 11.39, 11.53, 12.91, 13.17,
                  2.7,  4.77, 6.17, 6.7,  7.8,  9.1,  9.39, 10.56, 10.85, 12.23, 12.67, 13.18});
  const auto interval = [&](const char* formula, std::size_t place) {
    const FittedModel fit = fit_model(specify_model(formula, {}, table), table).fit;
    return confidence_intervals(fit, table, {.method = IntervalMethod::kProfile}).parameters[place];
  };
  // R 4: uniroot() of the F statistic on the sum of squares minimized over A (linear) and the other
  // coefficient (optimize() on a grid), in units that are finite at k = 0 and for A = infinity. Its
  // digits end at the square root of those of the minimum, hence 1e-4 of the length.
  const ParameterInterval rate = interval("y ~ A*exp(-b*exp(-k*x))", 2);
  CHECK(rate.lower == Approx(-0.0271801368).margin(6e-6));
  CHECK(rate.upper == Approx(0.0305823508).margin(6e-6));
  const ParameterInterval scale = interval("y ~ A/(1 + exp((m - x)/s))", 2);
  CHECK(scale.lower == Approx(5.80155722).margin(2e-5));
  CHECK(scale.upper == Approx(7.55381986).margin(2e-5));
  CHECK(scale.note.empty());
  // The limit of k towards 0 is the power A*x^p, inside the interval; below 0 the powers of
  // negative numbers have no value.
  const ParameterInterval edge = interval("z ~ A*(1 - exp(-k*x))^p", 1);
  CHECK(edge.lower == 0.0);
  CHECK(edge.note == "the formula has no value beyond 0");
  const ParameterInterval size = interval("z ~ A*(1 - exp(-k*x))^p", 0);
  CHECK(std::isinf(size.upper));
}

TEST_CASE("a profile that holds both infinities excludes the values around 0") {
  data::Table table;
  table.set("x", {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0});
  table.set("y", {1.53, 4.01, 6.62, 7.13, 9.48, 11.39, 13.44, 14.69, 17.51, 18.11, 20.03, 21.92});
  const FittedModel fit = fit_model(specify_model("y ~ V*x/(K + x)", {}, table), table).fit;
  REQUIRE(fit.estimate[1] > 0.0);
  const ParameterInterval interval =
      confidence_intervals(fit, table, {.method = IntervalMethod::kProfile}).parameters[1];
  // R 4: uniroot() of the F statistic of s*x/(1 + q*x): q from -0.001129288 to 0.01879984, so that
  // K = 1/q is above 53.19193292 or below -885.5.
  CHECK(interval.lower == Approx(53.19193292).epsilon(1e-4));
  CHECK(std::isinf(interval.upper));
  CHECK(interval.note.find("beyond infinity") != std::string::npos);
}

TEST_CASE("with a coefficient held, the others keep their profile intervals") {
  // y - 3 = b x by hand: b = sum x (y - 3) / sum x^2, and n - 1 degrees of freedom, whichever of
  // the coefficients is the held one.
  Random random(8);
  data::Table table;
  std::vector<double> x;
  std::vector<double> y;
  constexpr int kRows = 12;
  for (int i = 1; i <= kRows; ++i) {
    x.push_back(i);
    y.push_back(3.0 + 0.5 * i + random.normal());
  }
  table.set("x", x);
  table.set("y", y);
  double sxx = 0.0;
  double sxy = 0.0;
  double syy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += x[i] * x[i];
    sxy += x[i] * (y[i] - 3.0);
    syy += (y[i] - 3.0) * (y[i] - 3.0);
  }
  const double slope = sxy / sxx;
  const double error = std::sqrt((syy - slope * sxy) / (kRows - 1) / sxx);
  const double reach = error * boost::math::quantile(boost::math::students_t(kRows - 1.0), 0.975);
  for (const char* const formula : {"y ~ a + b*x", "y ~ b*x + a"}) {
    INFO(formula);
    FitModelOptions options;
    options.fixed = {{"a", 3.0}};
    const FittedModel fit = fit_model(specify_model(formula, {}, table), table, options).fit;
    for (const IntervalMethod method : {IntervalMethod::kProfile, IntervalMethod::kWald}) {
      const Intervals intervals = confidence_intervals(fit, table, {.method = method});
      REQUIRE(intervals.parameters.size() == 2);
      CHECK(intervals.parameters[0].name == "b");
      // Limits are roots to 1e-6 of the distance.
      CHECK(intervals.parameters[0].lower == Approx(slope - reach).margin(1e-5 * reach));
      CHECK(intervals.parameters[0].upper == Approx(slope + reach).margin(1e-5 * reach));
      CHECK(intervals.parameters[0].note.empty());
    }
  }
  // Beyond its bound, a would be near 3.
  FitModelOptions bounded;
  bounded.bounds = {{"a", {.low = 10.0}}};
  const FittedModel fit = fit_model(specify_model("y ~ a + b*x", {}, table), table, bounded).fit;
  CHECK_THAT(confidence_intervals(fit, table, {}).likelihood,
             Catch::Matchers::Contains(
                 "with a held at its bound; without, intervals are wider on one side"));
}

TEST_CASE("intervals of lb and of the marginal likelihood agree where the model is linear") {
  Random random(21);
  data::Table table;
  data::TextColumn plot;
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 12; ++i) {
    const double level = random.normal(0.0, 2.0);
    const double slope = 0.8 * level / 2.0 + random.normal(0.0, 0.5);
    for (int j = 0; j < 7; ++j) {
      plot.append(std::to_string(i));
      x.push_back(j - 3);
      y.push_back(10.0 + level + (1.0 + slope) * x.back() + random.normal());
    }
  }
  table.set("plot", plot);
  table.set("x", x);
  table.set("y", y);
  ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
  add_random_effects(model, "a + b | plot", table);
  const auto intervals = [&](Method method) {
    FitModelOptions options;
    options.method = method;
    return confidence_intervals(
        fit_model(model, table, options).fit, table, {.method = IntervalMethod::kProfile});
  };
  const Intervals linear = intervals(Method::kLindstromBates);
  const Intervals marginal = intervals(Method::kLaplace);
  REQUIRE(linear.parameters.size() == 6);
  for (std::size_t k = 0; k < linear.parameters.size(); ++k) {
    INFO(linear.parameters[k].name);
    const double length = linear.parameters[k].upper - linear.parameters[k].lower;
    CHECK(linear.parameters[k].lower == Approx(marginal.parameters[k].lower).margin(1e-4 * length));
    CHECK(linear.parameters[k].upper == Approx(marginal.parameters[k].upper).margin(1e-4 * length));
  }
}

TEST_CASE("profiles leave a variance of zero where the likelihood rises") {
  // Eight groups of five: y = 1 + 2 x + sin(4 i^2), x = g/4.
  data::Table table;
  data::TextColumn plot;
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 1; i <= 40; ++i) {
    const int g = (i + 4) / 5;
    plot.append(std::to_string(g));
    x.push_back(g / 4.0);
    y.push_back(1.0 + 2.0 * x.back() + std::sin(4.0 * i * i));
  }
  table.set("plot", plot);
  table.set("x", x);
  table.set("y", y);
  ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
  add_random_effects(model, "a | plot", table);
  // lme4 1.1-31: f <- lmer(y ~ x + (1 | g), d, REML = FALSE) is singular; the limits are the roots
  // of -2 logLik(lmer(I(y - b*x) ~ 1 + (1 | g), d, REML = FALSE)) + 2 logLik(f) - qchisq(0.95, 1),
  // by uniroot(tol = 1e-11). sd(a) is 0.18 there.
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    FitModelOptions options;
    options.method = method;
    const FittedModel fit = fit_model(model, table, options).fit;
    CHECK(fit.convergence.status == ConvergenceStatus::kBoundary);
    const Intervals found = confidence_intervals(fit, table, {.method = IntervalMethod::kProfile});
    REQUIRE(found.parameters[1].name == "b");
    // Limits are roots to 1e-6 of the distance.
    CHECK(found.parameters[1].lower == Approx(1.890977169677).margin(2e-6));
    CHECK(found.parameters[1].upper == Approx(2.702891916530).margin(2e-6));
  }
}

TEST_CASE("intervals are refused for other data, wrong levels and fits that failed") {
  const data::Table table = curves();
  FittedModel fit = fitted_by_method(table, "a | plot", "none", "lb");
  CHECK_THROWS_AS(confidence_intervals(fit, curves(8)), UsageError);
  CHECK_THROWS_AS(confidence_intervals(fit, table, {.level = 1.0}), UsageError);
  CHECK_THROWS_AS(value_of<IntervalMethod>("bootstrap", "kind of interval"), UsageError);
  FittedModel exact = fit;
  exact.sigma = 0.0;
  CHECK_THROWS_WITH(confidence_intervals(exact, table), Catch::Matchers::Contains("perfect fit"));
  fit.convergence.status = ConvergenceStatus::kDiverged;
  CHECK_THROWS_AS(confidence_intervals(fit, table), UsageError);
}

TEST_CASE("intervals are read back from JSON, also unbounded ones") {
  FittedModel fit = fitted_by_method(curves(), "a | plot", "none", "lb");
  fit.intervals = Intervals{.method = IntervalMethod::kProfile,
                            .level = 0.9,
                            .likelihood = "some likelihood",
                            .parameters = {{.name = "a",
                                            .estimate = 1.5,
                                            .lower = -std::numeric_limits<double>::infinity(),
                                            .upper = 2.5,
                                            .note = "no lower limit"},
                                           {.kind = ParameterKind::kDeviation,
                                            .name = "sd(a)",
                                            .estimate = 0.5,
                                            .lower = 0.0,
                                            .upper = NAN}}};
  const FittedModel read = from_json(to_json(fit), "fit.json");
  REQUIRE(read.intervals.has_value());
  CHECK(read.intervals->level == 0.9);
  CHECK(read.intervals->method == IntervalMethod::kProfile);
  REQUIRE(read.intervals->parameters.size() == 2);
  CHECK(read.intervals->parameters[0].lower == -INFINITY);
  CHECK(read.intervals->parameters[0].note == "no lower limit");
  CHECK(read.intervals->parameters[1].kind == ParameterKind::kDeviation);
  CHECK(std::isnan(read.intervals->parameters[1].upper));
  CHECK(to_json(read) == to_json(fit));
}

TEST_CASE("profile intervals have their stated coverage", "[slow]") {
  // A random intercept in 40 plots of 5: large enough for the chi-squared reference. 300 data sets
  // tell 95 % from others with a standard error of 1.3 points.
  constexpr int kDataSets = 300;
  const std::vector<double> truth{10.0, 2.0, 1.5, 1.0};
  std::vector<int> covered(truth.size(), 0);
  for (int set = 0; set < kDataSets; ++set) {
    Random random(99, static_cast<std::uint64_t>(set));
    data::Table table;
    data::TextColumn plot;
    std::vector<double> x;
    std::vector<double> y;
    for (int i = 0; i < 40; ++i) {
      const double effect = random.normal(0.0, truth[2]);
      for (int j = 0; j < 5; ++j) {
        plot.append(std::to_string(i));
        x.push_back(j - 2 + 0.1 * i);
        y.push_back(truth[0] + effect + truth[1] * x.back() + random.normal(0.0, truth[3]));
      }
    }
    table.set("plot", plot);
    table.set("x", x);
    table.set("y", y);
    ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
    add_random_effects(model, "a | plot", table);
    const FittedModel fit = fit_model(model, table).fit;
    const Intervals intervals =
        confidence_intervals(fit, table, {.method = IntervalMethod::kProfile});
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const ParameterInterval& one = intervals.parameters[k];
      if (one.lower <= truth[k] && truth[k] <= one.upper) ++covered[k];
    }
  }
  const double error = std::sqrt(0.95 * 0.05 / kDataSets);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    // Three binomial standard errors, and a point for what 40 plots are short of infinitely many.
    CHECK(static_cast<double>(covered[k]) / kDataSets == Approx(0.95).margin(3.0 * error + 0.01));
  }
}
