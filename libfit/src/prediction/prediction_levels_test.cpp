// SPDX-License-Identifier: MIT
// Levels, errors and intervals of predictions against theory and simulation.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <boost/math/distributions/students_t.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "prediction/mixture_quantile.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/prediction.hpp"
#include "test_support/known_fit.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::Random;
using silvafit::data::Table;
using silvafit::data::TextColumn;
using namespace silvafit::fit;
using Catch::Matchers::Contains;
using silvafit::kNaN;

namespace {

/// y = mu + b + e with Var b = 4 and Var e = 9, from six groups of three, so that the trees of a
/// group have the shrinkage 3*4/(3*4 + 9) = 4/7 and leave 4 (1 - 4/7) of b open, and Var(mu-hat) =
/// (4 + 9/3)/6.
FittedModel one_way() {
  FittedModel fit = model("y ~ mu + 0*x", {"mu"}, "mu | plot");
  fit.estimate = VectorXd::Constant(1, 10.0);
  fit.covariance.setConstant(7.0 / 6.0);
  fit.random.back().covariance = MatrixXd::Constant(1, 1, 4.0);
  fit.sigma = 3.0;
  fit.random.back().labels = {"1", "2", "3", "4", "5", "6"};
  fit.random.back().effects.setZero(1, 6);
  fit.random.back().uncertainty = {.covariances = MatrixXd::Constant(1, 6, 12.0 / 7.0),
                                   .sensitivities = MatrixXd::Constant(1, 6, -4.0 / 7.0)};
  return fit;
}

/// A height curve with random asymptote and rate, and so many plots that t is nearly normal.
FittedModel curve() {
  FittedModel fit = model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {"a", "b"}, "a + b | plot");
  fit.estimate = Eigen::Vector2d(25.0, 0.06);
  fit.covariance = Eigen::Matrix2d{{0.3, -5e-4}, {-5e-4, 4e-6}};
  fit.random.back().covariance = Eigen::Matrix2d{{9.0, -0.015}, {-0.015, 2e-4}};
  fit.sigma = 0.3;
  fit.variance = VarianceEstimate::missing(parse_variance_function("power"));
  fit.variance.factors[0].delta[0] = 0.6;
  fit.degrees_of_freedom = Eigen::VectorXd::Constant(1, 1e6);
  fit.random.back().labels.assign(100001, "");
  for (std::size_t g = 0; g < fit.random.back().labels.size(); ++g)
    fit.random.back().labels[g] = fmt::format("{}", g);
  fit.random.back().effects.setZero(2, 100001);
  fit.random.back().uncertainty.covariances.setZero(4, 100001);
  fit.random.back().uncertainty.sensitivities.setZero(4, 100001);
  return fit;
}

double height(double a, double b, double dbh) { return 1.3 + a * (1.0 - std::exp(-b * dbh)); }

double student_quantile(double freedom, double coverage) {
  return boost::math::quantile(boost::math::students_t_distribution<double>(freedom),
                               0.5 + 0.5 * coverage);
}

}  // namespace

TEST_CASE("in the one-way layout errors and intervals are those of theory") {
  const FittedModel fit = one_way();
  Table table;
  table.set("plot", texts({"A", "A", "A", "A", "B"}));
  table.set("x", std::vector<double>(5, 0.0));
  table.set("y", std::vector<double>{13.0, 16.0, 10.0, kNaN, kNaN});
  const Prediction prediction = predict(fit, table, Level::kCalibrated, {.interval = 0.9});
  // Three trees with mean 13: shrinkage 3*4/(3*4 + 9) = 4/7, so b = 12/7.
  const double shrinkage = 4.0 / 7.0;
  const double known = 4.0 * (1.0 - shrinkage) + std::pow(1.0 - shrinkage, 2) * 7.0 / 6.0;
  CHECK(prediction.value[3] == Approx(10.0 + 3.0 * shrinkage).epsilon(1e-12));
  CHECK(prediction.mean_error[3] == Approx(std::sqrt(known)).epsilon(1e-12));
  CHECK(prediction.prediction_error[3] == Approx(std::sqrt(known + 9.0)).epsilon(1e-12));
  CHECK(prediction.calibrated_from == std::vector<Index>{3, 3, 3, 3, 0});
  CHECK(prediction.unknown_terms == std::vector<unsigned>{0, 0, 0, 0, 1});
  // Nothing is known of plot B.
  CHECK(prediction.value[4] == Approx(10.0));
  CHECK(prediction.mean_error[4] == Approx(std::sqrt(7.0 / 6.0)));
  CHECK(prediction.prediction_error[4] == Approx(std::sqrt(7.0 / 6.0 + 4.0 + 9.0)));
  // The mean squares between (4 + 9/3, five degrees of freedom) and within plots (9, 100) make up
  // the variance of a tree of another plot: 7 (1 + 1/6) + 9 (1 - 1/3).
  const double between = 7.0 * (1.0 + 1.0 / 6.0);
  const double variance = between + 6.0;
  const double freedom = variance * variance / (between * between / 5.0 + 36.0 / 100.0);
  CHECK(prediction.degrees_of_freedom[4] == Approx(freedom).epsilon(1e-12));
  // The quadrature has 15 points for normal distributions whose mixture is normal; its end is exact
  // to about 1e-6 where the components are as wide as their spread.
  const double margin = student_quantile(freedom, 0.9) * std::sqrt(variance);
  CHECK(prediction.lower[4] == Approx(10.0 - margin).epsilon(1e-5));
  CHECK(prediction.upper[4] == Approx(10.0 + margin).epsilon(1e-5));
  const Prediction mean = predict(fit,
                                  table,
                                  Level::kCalibrated,
                                  {.interval = 0.9, .interval_kind = IntervalKind::kConfidence});
  const double half = student_quantile(mean.degrees_of_freedom[3], 0.9) * std::sqrt(known);
  CHECK(mean.lower[3] == Approx(prediction.value[3] - half).epsilon(1e-12));
  CHECK(mean.upper[3] == Approx(prediction.value[3] + half).epsilon(1e-12));
  CHECK(mean.degrees_of_freedom[4] == Approx(5.0));
}

TEST_CASE("population prediction intervals have their coverage in simulations") {
  const FittedModel fit = curve();
  Table table;
  const std::vector<double> diameters{6.0, 20.0, 45.0};
  table.set("dbh", diameters);
  const Prediction prediction = predict(fit, table, Level::kPopulation, {.interval = 0.95});
  const MatrixXd of_fixed = fit.covariance.llt().matrixL();
  const MatrixXd of_random = fit.random.back().covariance.llt().matrixL();
  Random random(3);
  constexpr int kDraws = 200000;
  Eigen::Vector3d below = Eigen::Vector3d::Zero();
  Eigen::Vector3d above = Eigen::Vector3d::Zero();
  for (int draw = 0; draw < kDraws; ++draw) {
    const VectorXd at = fit.estimate +
                        of_fixed * Eigen::Vector2d(random.normal(), random.normal()) +
                        of_random * Eigen::Vector2d(random.normal(), random.normal());
    for (Index i = 0; i < 3; ++i) {
      const double mean = height(at[0], at[1], diameters[static_cast<std::size_t>(i)]);
      const double value = mean + random.normal(0.0, 0.3 * std::pow(std::abs(mean), 0.6));
      if (value < prediction.lower[i]) below[i] += 1.0 / kDraws;
      if (value > prediction.upper[i]) above[i] += 1.0 / kDraws;
    }
  }
  // Four standard errors of a share of 0.025 among the draws.
  const double tolerance = 4.0 * std::sqrt(0.025 * 0.975 / kDraws);
  for (Index i = 0; i < 3; ++i) {
    CHECK(below[i] == Approx(0.025).margin(tolerance));
    CHECK(above[i] == Approx(0.025).margin(tolerance));
  }
}

TEST_CASE("calibrated intervals have their coverage for new trees of simulated plots") {
  const FittedModel fit = curve();
  const MatrixXd of_fixed = fit.covariance.llt().matrixL();
  const MatrixXd of_random = fit.random.back().covariance.llt().matrixL();
  const int measured = GENERATE(1, 4);
  Random random(8);
  constexpr int kPlots = 5000;
  TextColumn plot;
  std::vector<double> dbh;
  std::vector<double> h;
  std::vector<double> truth;
  for (int i = 0; i < kPlots; ++i) {
    const VectorXd at = fit.estimate +
                        of_fixed * Eigen::Vector2d(random.normal(), random.normal()) +
                        of_random * Eigen::Vector2d(random.normal(), random.normal());
    for (int j = 0; j <= measured; ++j) {
      plot.append(fmt::format("new {}", i));
      dbh.push_back(random.uniform(8.0, 40.0));
      const double mean = height(at[0], at[1], dbh.back());
      truth.push_back(mean + random.normal(0.0, 0.3 * std::pow(std::abs(mean), 0.6)));
      h.push_back(j < measured ? truth.back() : kNaN);
    }
  }
  Table table;
  table.set("plot", plot);
  table.set("dbh", dbh);
  table.set("h", h);
  for (const double coverage : {0.9, 0.95}) {
    const Prediction prediction =
        predict(fit, table, Level::kCalibrated, {.interval = coverage, .threads = 2});
    double held = 0.0;
    for (std::size_t row = 0; row < truth.size(); ++row) {
      const auto at = static_cast<Index>(row);
      const bool is_new = std::isnan(h[row]);
      if (is_new && truth[row] >= prediction.lower[at] && truth[row] <= prediction.upper[at]) {
        held += 1.0 / kPlots;
      }
    }
    // Four standard errors of the share, and half a point for the random effects' distribution
    // given few trees, which is not quite normal.
    const double tolerance = 4.0 * std::sqrt(coverage * (1.0 - coverage) / kPlots) + 0.005;
    CHECK(held == Approx(coverage).margin(tolerance));
  }
}

TEST_CASE("errors and intervals include the error of a predicted predictor") {
  FittedModel fit = model("hcb ~ c + d*h", {"c", "d"}, "c | plot");
  fit.estimate = Eigen::Vector2d(1.0, 0.5);
  fit.covariance = Eigen::Matrix2d{{0.04, 0.0}, {0.0, 0.0001}};
  fit.random.back().covariance = MatrixXd::Constant(1, 1, 0.25);
  Table table;
  table.set("h", std::vector<double>{20.0, 20.0});
  const UncertainColumn height_error{.name = "h",
                                     .mean_variance = Eigen::Vector2d(0.0, 0.6),
                                     .tree_variance = Eigen::Vector2d(0.0, 4.0)};
  const Prediction prediction =
      predict(fit, table, Level::kPopulation, {.interval = 0.95, .uncertain = {height_error}});
  const double of_mean = 0.04 + 0.0001 * 400.0;
  CHECK(prediction.value[0] == prediction.value[1]);
  CHECK(prediction.mean_error[0] == Approx(std::sqrt(of_mean)));
  CHECK(prediction.mean_error[1] == Approx(std::sqrt(of_mean + 0.25 * 0.6)));
  CHECK(prediction.prediction_error[0] == Approx(std::sqrt(of_mean + 0.25 + 1.0)));
  CHECK(prediction.prediction_error[1] == Approx(std::sqrt(of_mean + 0.25 + 1.0 + 0.25 * 4.0)));
  CHECK(prediction.upper[1] - prediction.lower[1] > prediction.upper[0] - prediction.lower[0]);
}

TEST_CASE("confidence intervals stay within the range of the curve") {
  FittedModel fit = model("hcb ~ h/(1 + exp(a))", {"a"}, "a | plot");
  fit.estimate = VectorXd::Constant(1, 0.3);
  fit.covariance.setConstant(4.0);
  fit.random.back().covariance = MatrixXd::Constant(1, 1, 1.0);
  Table table;
  table.set("h", std::vector<double>{20.0});
  const Prediction prediction =
      predict(fit,
              table,
              Level::kPopulation,
              {.interval = 0.95, .interval_kind = IntervalKind::kConfidence});
  const double t = student_quantile(prediction.degrees_of_freedom[0], 0.95);
  CHECK(prediction.lower[0] == Approx(20.0 / (1.0 + std::exp(0.3 + 2.0 * t))));
  CHECK(prediction.upper[0] == Approx(20.0 / (1.0 + std::exp(0.3 - 2.0 * t))));
}

TEST_CASE("a mean with an unknown error has no interval, without error one of width zero") {
  FittedModel fit = model("y ~ sqrt(a*x)", {"a"}, "a | plot");
  fit.estimate = VectorXd::Constant(1, 4.0);
  fit.covariance.setConstant(kNaN);
  fit.random.back().covariance = MatrixXd::Constant(1, 1, 0.5);
  Table table;
  table.set("x", std::vector<double>{0.0});
  const PredictionOptions options{.interval = 0.95, .interval_kind = IntervalKind::kConfidence};
  const Prediction unknown = predict(fit, table, Level::kPopulation, options);
  CHECK(unknown.value[0] == 0.0);
  CHECK(std::isnan(unknown.mean_error[0]));
  CHECK(std::isnan(unknown.lower[0]));
  CHECK(std::isnan(unknown.upper[0]));
  fit.covariance.setConstant(1.0);
  // At x = 0 these means are constant in a, although x/(2 sqrt(a x)) is 0/0.
  for (const char* const formula : {"y ~ 2 + a*x", "y ~ 2 + sqrt(a*x)", "y ~ 2 + (x/a)^0.5"}) {
    fit.specification.formula = silvafit::data::parse_formula(formula);
    const Prediction exact = predict(fit, table, Level::kPopulation, options);
    CHECK(exact.lower[0] == 2.0);
    CHECK(exact.upper[0] == 2.0);
  }
}

TEST_CASE("predictions of unknown groups follow the option") {
  const FittedModel fit = curve();
  Table table;
  table.set("plot", texts({"new", "old"}));
  table.set("dbh", std::vector<double>{20.0, 20.0});
  table.set("h", std::vector<double>{kNaN, 18.0});
  const auto at = [&](NewGroups choice) {
    return predict(fit, table, Level::kCalibrated, {.new_groups = choice, .interval = 0.95});
  };
  CHECK(at(NewGroups::kPopulation).value[0] == Approx(height(25.0, 0.06, 20.0)));
  const double marginal = predict(fit, table, Level::kMarginal).value[0];
  CHECK(at(NewGroups::kMarginal).value[0] == Approx(marginal).epsilon(1e-14));
  CHECK(at(NewGroups::kMarginal).value[1] == at(NewGroups::kPopulation).value[1]);
  CHECK(std::isnan(at(NewGroups::kMissing).value[0]));
  CHECK(std::isnan(at(NewGroups::kMissing).lower[0]));
  CHECK_THROWS_WITH(at(NewGroups::kError), Contains("no measured tree"));
}

TEST_CASE("an interval needs a valid level and a fit with the necessary data") {
  FittedModel fit = one_way();
  Table table;
  table.set("plot", texts({"1"}));
  table.set("x", std::vector<double>{0.0});
  CHECK_THROWS_WITH(predict(fit, table, Level::kPopulation, {.interval = 1.0}),
                    Contains("between 0 and 1"));
  fit.random.back().uncertainty = {};
  CHECK(predict(fit, table, Level::kConditional).value[0] == 10.0);
  CHECK_THROWS_WITH(predict(fit, table, Level::kConditional, {.interval = 0.9}),
                    Contains("fit the model again"));
}

TEST_CASE("quantiles of a mixture agree with its distribution function") {
  const Eigen::Vector3d means(0.0, 5.0, -2.0);
  const Eigen::Vector3d deviations(1.0, 0.5, 3.0);
  const Eigen::Vector3d weights(0.5, 0.3, 0.2);
  const auto distribution = [&](double y) {
    double sum = 0.0;
    for (Index k = 0; k < 3; ++k) {
      sum += weights[k] * 0.5 * std::erfc((means[k] - y) / deviations[k] / std::sqrt(2.0));
    }
    return sum;
  };
  for (const double probability : {0.001, 0.025, 0.5, 0.85, 0.999}) {
    const double y =
        NormalMixture(means, deviations, weights, std::min(probability, 1.0 - probability))
            .quantile(probability);
    CHECK(distribution(y) == Approx(probability).epsilon(1e-8));
  }
  // A plateau between a narrow component and a very wide one, at a probability next to it.
  for (const double probability : {0.9749, 0.9751, 0.98, 0.9999}) {
    const NormalMixture wide(
        Eigen::Vector2d(20.0, 1e6), Eigen::Vector2d(1.0, 1e8), Eigen::Vector2d(0.95, 0.05), 0.0001);
    const double y = wide.quantile(probability);
    const double sum = 0.95 * 0.5 * std::erfc((20.0 - y) / std::sqrt(2.0)) +
                       0.05 * 0.5 * std::erfc((1e6 - y) / 1e8 / std::sqrt(2.0));
    CHECK(sum == Approx(probability).epsilon(1e-8));
  }
  // One normal distribution, and one whose other component is not finite.
  CHECK(NormalMixture(
            VectorXd::Constant(1, 2.0), VectorXd::Constant(1, 3.0), VectorXd::Ones(1), 0.025)
            .quantile(0.975) == Approx(2.0 + 3.0 * 1.959963984540054));
  CHECK(NormalMixture(
            Eigen::Vector2d(2.0, kNaN), Eigen::Vector2d(3.0, 1.0), Eigen::Vector2d(0.5, 0.5), 0.5)
            .quantile(0.5) == Approx(2.0));
}

namespace {

/// y = mu + b + e with Var e = 1, mu known.
FittedModel separated(double between) {
  FittedModel fit = model("y ~ mu + 0*x", {"mu"}, "mu | plot");
  fit.estimate = VectorXd::Constant(1, 100.0);
  fit.random.back().covariance = MatrixXd::Constant(1, 1, between * between);
  fit.random.back().labels.assign(40, "");
  return fit;
}

/// Naslund's height curve with the estimates from the pines of spati, taken as known: plots differ
/// ten times as much as trees do, and the curve is bent.
FittedModel naslund() {
  FittedModel fit = curve();
  const FittedModel shape = model("h ~ 1.3 + dbh^2/(a + b*dbh)^2", {"a", "b"}, "a + b | plot");
  fit.specification.formula = shape.specification.formula;
  fit.estimate = Eigen::Vector2d(1.0752270, 0.2331406);
  fit.covariance.setZero();
  const double joint = -0.45603 * 0.27553578 * 0.05962333;
  fit.random.back().covariance = Eigen::Matrix2d{{0.075919966, joint}, {joint, 0.003554941}};
  fit.sigma = 0.3983975;
  fit.variance = VarianceEstimate::missing(parse_variance_function("power(dbh)"));
  fit.variance.factors[0].delta[0] = 0.386452;
  return fit;
}

/// P(value < each limit) over both random effects, by the trapezoid rule with steps of 1/50.
VectorXd probabilities_below(const FittedModel& fit, double dbh, const VectorXd& limits) {
  const MatrixXd root = fit.random.back().covariance.llt().matrixL();
  constexpr int kSide = 300;
  constexpr double kStep = 0.02;
  VectorXd below = VectorXd::Zero(limits.size());
  double total = 0.0;
  for (int i = -kSide; i <= kSide; ++i) {
    for (int j = -kSide; j <= kSide; ++j) {
      const Eigen::Vector2d u(kStep * i, kStep * j);
      const double weight = std::exp(-0.5 * u.squaredNorm());
      const VectorXd at = fit.estimate + root * u;
      const double mean = 1.3 + std::pow(dbh / (at[0] + at[1] * dbh), 2);
      const double sd = fit.sigma * std::pow(dbh, 0.386452);
      total += weight;
      for (Index k = 0; k < limits.size(); ++k) {
        below[k] += weight * 0.5 * std::erfc((mean - limits[k]) / sd / std::sqrt(2.0));
      }
    }
  }
  return below / total;
}

}  // namespace

TEST_CASE("predicted intervals of new groups are normal ones for any variance of groups") {
  const double between = GENERATE(0.0, 0.1, 0.4, 1.0, 5.0, 20.0, 1000.0);
  const FittedModel fit = separated(between);
  Table table;
  table.set("x", std::vector<double>{0.0});
  for (const double coverage : {0.5, 0.8, 0.9, 0.95, 0.99}) {
    const Prediction prediction = predict(fit, table, Level::kPopulation, {.interval = coverage});
    const double deviation = std::hypot(between, 1.0);
    const double freedom = std::pow(deviation, 4) / (std::pow(between, 4) / 39.0 + 1.0 / 100.0);
    const double margin = student_quantile(freedom, coverage) * deviation;
    // The distribution function of the rule is within 1e-6 of the normal one's.
    INFO(between << " " << coverage);
    CHECK(prediction.upper[0] - 100.0 == Approx(margin).epsilon(2e-5));
    CHECK(100.0 - prediction.lower[0] == Approx(margin).epsilon(2e-5));
  }
}

TEST_CASE("predicted intervals of a nonlinear curve agree with a very fine quadrature") {
  FittedModel fit = naslund();
  fit.sigma *= GENERATE(0.01, 0.3, 1.0, 3.0);
  const double dbh = GENERATE(5.0, 20.3, 40.0);
  Table table;
  table.set("dbh", std::vector<double>{dbh});
  for (const double coverage : {0.5, 0.8, 0.95, 0.99}) {
    const Prediction prediction = predict(fit, table, Level::kPopulation, {.interval = coverage});
    const VectorXd below =
        probabilities_below(fit, dbh, Eigen::Vector2d(prediction.lower[0], prediction.upper[0]));
    const double tail = 0.5 - 0.5 * coverage;
    INFO(fit.sigma << " " << dbh << " " << coverage);
    // Components have the mean and variance of their neighborhood, but not its skewness, and
    // across the main direction there are few points.
    CHECK(below[0] == Approx(tail).epsilon(0.015));
    CHECK(1.0 - below[1] == Approx(tail).epsilon(0.015));
  }
}

TEST_CASE("limits of intervals of new plots agree with the quantiles of simulated pines") {
  Table table;
  table.set("dbh", std::vector<double>{20.3});
  // Of 2,000,000 trees simulated in R, with the standard errors of these quantiles.
  struct End {
    double coverage;
    double upper;
    double error;
  };
  for (const End& end :
       {End{0.8, 22.91, 0.013}, End{0.95, 32.77, 0.036}, End{0.97, 37.28, 0.053}}) {
    const Prediction prediction =
        predict(naslund(), table, Level::kPopulation, {.interval = end.coverage});
    CHECK(prediction.upper[0] == Approx(end.upper).margin(4.0 * end.error));
  }
}
