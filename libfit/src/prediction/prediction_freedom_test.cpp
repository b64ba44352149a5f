// SPDX-License-Identifier: MIT
// Degrees of freedom of predictions against R, the analysis of variance and simulation.
#include <fmt/format.h>

#include <boost/math/distributions/students_t.hpp>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/prediction.hpp"

using Eigen::Index;
using Eigen::VectorXd;
using silvafit::Random;
using silvafit::data::Table;
using silvafit::data::TextColumn;
using namespace silvafit::fit;

namespace {

// Relative difference of the variances by restricted likelihood from those of the analysis of
// variance: the error of the search, 1e-7, times the largest factor in the computation.
constexpr double kSearch = 1e-5;

double t_quantile(double freedom, double coverage) {
  return boost::math::quantile(boost::math::students_t_distribution<double>(freedom),
                               0.5 + 0.5 * coverage);
}

FittedModel fitted(const Table& table, const char* formula, const char* random, bool reml = true) {
  ModelSpecification model = specify_model(formula, {}, table);
  if (*random != '\0') add_random_effects(model, random, table);
  FittedModel fit = fit_model(model, table, {.reml = reml}).fit;
  REQUIRE(fit.convergence.converged());
  return fit;
}

/// Trees of plots of stands, balanced: y = 20 + slope x + stand + plot + tree.
struct Layout {
  int stands = 1;
  int plots = 4;  ///< of each stand
  int trees = 6;  ///< of each plot
  double sd_stand = 0.0;
  double sd_plot = 3.0;
  double sd_tree = 0.3;
  double slope = 0.0;
};

Table layout(const Layout& of, Random& random) {
  Table table;
  TextColumn stand;
  TextColumn plot;
  std::vector<double> x;
  std::vector<double> y;
  for (int s = 0; s < of.stands; ++s) {
    const double of_stand = random.normal(0.0, of.sd_stand);
    for (int p = 0; p < of.plots; ++p) {
      const double of_plot = random.normal(0.0, of.sd_plot);
      // Neither balanced nor in order, but the same in all trees of a plot.
      const double site = static_cast<double>((7 * p + 3) % 11);
      for (int t = 0; t < of.trees; ++t) {
        stand.append(fmt::format("S/{}", s));  // nested labels write the slash as %2F
        plot.append(fmt::format("P{}.{}", s, p));
        x.push_back(site);
        y.push_back(20.0 + of.slope * site + of_stand + of_plot + random.normal(0.0, of.sd_tree));
      }
    }
  }
  table.set("stand", stand);
  table.set("plot", plot);
  table.set("x", x);
  table.set("y", y);
  return table;
}

/// A mean square of the analysis of variance.
struct MeanSquare {
  double value = 0.0;
  double freedom = 0.0;
};

/// Of units of equal size, consecutive in a table, around means of the units that hold them.
/// \param size, whole  rows of a unit and of what holds it
MeanSquare mean_square(const Table& table, std::size_t size, std::size_t whole) {
  const auto y = table.numbers("y");
  const Eigen::Map<const VectorXd> all(y.data(), static_cast<Index>(y.size()));
  MeanSquare result;
  for (std::size_t begin = 0; begin < y.size(); begin += size) {
    const auto first = static_cast<Index>(begin - begin % whole);
    const double mean = all.segment(static_cast<Index>(begin), static_cast<Index>(size)).mean();
    const double around = all.segment(first, static_cast<Index>(whole)).mean();
    result.value += static_cast<double>(size) * std::pow(mean - around, 2);
  }
  const double rows = static_cast<double>(y.size());
  result.freedom = rows / static_cast<double>(size) - rows / static_cast<double>(whole);
  result.value /= result.freedom;
  return result;
}

/// Satterthwaite's degrees of freedom of sum c MS.
double satterthwaite(const std::vector<std::pair<double, MeanSquare>>& terms) {
  double sum = 0.0;
  double squares = 0.0;
  for (const auto& [factor, square] : terms) {
    sum += factor * square.value;
    squares += std::pow(factor * square.value, 2) / square.freedom;
  }
  return sum * sum / squares;
}

Table one_row() {
  Table table;
  table.set("x", std::vector<double>{4.0});
  return table;
}

Prediction population(const FittedModel& fit,
                      IntervalKind kind = IntervalKind::kPrediction,
                      const Table& table = one_row()) {
  return predict(fit, table, Level::kPopulation, {.interval = 0.95, .interval_kind = kind});
}

}  // namespace

TEST_CASE("intervals of a line are those of R") {
  Table table;
  table.set("x", std::vector<double>{5.0, 10.0, 15.0, 20.0, 25.0});
  table.set("y", std::vector<double>{6.1, 9.0, 13.9, 15.2, 21.0});
  const FittedModel fit = fitted(table, "y ~ a + b*x", "", false);
  Table at;
  at.set("x", std::vector<double>{5.0, 15.0, 40.0});
  const Prediction prediction = population(fit, IntervalKind::kPrediction, at);
  const Prediction mean = population(fit, IntervalKind::kConfidence, at);
  // R 4.2: predict(lm(y ~ x), interval = "prediction") and "confidence", ten digits.
  const Eigen::Vector3d lower(1.398539201, 9.193582118, 24.285912168);
  const Eigen::Vector3d upper(10.28146080, 16.88641788, 37.79408783);
  const Eigen::Vector3d mean_lower(3.120171833, 11.469706475, 25.270373177);
  const Eigen::Vector3d mean_upper(8.559828167, 14.610293525, 36.809626823);
  for (Index i = 0; i < 3; ++i) {
    CHECK(prediction.degrees_of_freedom[i] == 3.0);
    CHECK(mean.degrees_of_freedom[i] == 3.0);
    // The quadrature of a normal mixture is exact to 2e-5 of the half-width (docs/prediction.md).
    const double tolerance = 2e-5 * (upper[i] - lower[i]);
    CHECK(prediction.lower[i] == Approx(lower[i]).margin(tolerance));
    CHECK(prediction.upper[i] == Approx(upper[i]).margin(tolerance));
    CHECK(mean.lower[i] == Approx(mean_lower[i]).epsilon(1e-8));
    CHECK(mean.upper[i] == Approx(mean_upper[i]).epsilon(1e-8));
  }
}

TEST_CASE("without random effects the degrees of freedom are those of the residual") {
  Random random(2);
  Table table;
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 1; i <= 20; ++i) {
    x.push_back(i);
    y.push_back(3.0 + 2.0 * i + random.normal(0.0, 0.1 * i));
  }
  table.set("x", x);
  table.set("y", y);
  ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
  model.variance = parse_variance_function("power(x)");
  const FittedModel fit = fit_model(model, table).fit;
  REQUIRE(fit.convergence.converged());
  CHECK(population(fit).degrees_of_freedom[0] == 18.0);
  CHECK(population(fit, IntervalKind::kConfidence).degrees_of_freedom[0] == 18.0);
}

TEST_CASE("in balanced layouts degrees of freedom are those of the analysis of variance") {
  Random random(5);
  SECTION("of plots") {
    const double sd_plot = GENERATE(3.0, 0.4);
    const Layout of{.plots = 5, .trees = 4, .sd_plot = sd_plot, .sd_tree = 0.5};
    const Table table = layout(of, random);
    const FittedModel fit = fitted(table, "y ~ mu + 0*x", "mu | plot");
    const MeanSquare between = mean_square(table, 4, 20);
    const MeanSquare within = mean_square(table, 1, 4);
    REQUIRE(between.value > within.value);
    // Var(new tree) = psi + sigma^2 + Var(mean) = MSB (1 + 1/5)/4 + MSW (1 - 1/4).
    const double expected = satterthwaite({{1.2 / 4.0, between}, {0.75, within}});
    CHECK(population(fit).degrees_of_freedom[0] == Approx(expected).epsilon(kSearch));
    CHECK(population(fit, IntervalKind::kConfidence).degrees_of_freedom[0] ==
          Approx(4.0).epsilon(kSearch));
  }
  SECTION("of plots in stands") {
    const Layout of{
        .stands = 6, .plots = 3, .trees = 4, .sd_stand = 2.0, .sd_plot = 1.0, .sd_tree = 0.8};
    const Table table = layout(of, random);
    const FittedModel fit = fitted(table, "y ~ mu + 0*x", "mu | stand/plot");
    const MeanSquare stands = mean_square(table, 12, 72);
    const MeanSquare plots = mean_square(table, 4, 12);
    const MeanSquare within = mean_square(table, 1, 4);
    REQUIRE(stands.value > plots.value);
    REQUIRE(plots.value > within.value);
    const double expected = satterthwaite(
        {{(1.0 + 1.0 / 6.0) / 12.0, stands}, {(1.0 - 1.0 / 3.0) / 4.0, plots}, {0.75, within}});
    CHECK(population(fit).degrees_of_freedom[0] == Approx(expected).epsilon(kSearch));
    CHECK(population(fit, IntervalKind::kConfidence).degrees_of_freedom[0] ==
          Approx(5.0).epsilon(kSearch));
  }
}

TEST_CASE("a covariate of plots has the confidence interval of the line through their means") {
  Random random(9);
  const int plots = 7;
  const int trees = 3;
  const Table table =
      layout({.plots = plots, .trees = trees, .sd_plot = 1.0, .slope = 1.0}, random);
  const FittedModel fit = fitted(table, "y ~ a + b*x", "a | plot");
  const auto x = table.numbers("x");
  const auto y = table.numbers("y");
  VectorXd means(plots);
  VectorXd sites(plots);
  for (Index p = 0; p < plots; ++p) {
    const auto first = static_cast<std::size_t>(p * trees);
    sites[p] = x[first];
    means[p] = (y[first] + y[first + 1] + y[first + 2]) / trees;
  }
  // The mean of balanced plots is all that the line depends on.
  const VectorXd centered = sites.array() - sites.mean();
  const double slope = centered.dot(means) / centered.squaredNorm();
  const VectorXd rest = means.array() - means.mean() - slope * centered.array();
  const double leverage = 1.0 / plots + std::pow(4.0 - sites.mean(), 2) / centered.squaredNorm();
  const double error = std::sqrt(rest.squaredNorm() / (plots - 2) * leverage);
  const double center = means.mean() + slope * (4.0 - sites.mean());
  const Prediction mean = population(fit, IntervalKind::kConfidence);
  CHECK(mean.degrees_of_freedom[0] == Approx(plots - 2.0).epsilon(kSearch));
  CHECK(mean.lower[0] == Approx(center - t_quantile(5.0, 0.95) * error).epsilon(kSearch));
  CHECK(mean.upper[0] == Approx(center + t_quantile(5.0, 0.95) * error).epsilon(kSearch));
}

TEST_CASE("covariates of trees do not reduce the degrees of freedom of groups") {
  Random random(4);
  constexpr int kPlots = 20;
  Table table = layout({.plots = kPlots, .trees = 2, .sd_plot = 1.0, .sd_tree = 1.0}, random);
  std::vector<double> x;
  std::vector<double> z;
  for (int plot = 0; plot < kPlots; ++plot) {
    for (const double side : {-1.0, 1.0}) {
      x.push_back(side);
      z.push_back(plot % 2 == 0 ? side : -side);
    }
  }
  table.set("x", x);
  table.set("z", z);
  const FittedModel fit = fitted(table, "y ~ a + b*x + c*z", "a | plot");
  Table at;
  at.set("x", std::vector<double>{0.0});
  at.set("z", std::vector<double>{0.0});
  // Each plot's mean is of x = z = 0, and the prediction is the mean of 20 of them.
  CHECK(population(fit, IntervalKind::kConfidence, at).degrees_of_freedom[0] ==
        Approx(kPlots - 1.0).epsilon(kSearch));
}

TEST_CASE("a covariate of plots in stands reduces their degrees of freedom by one") {
  Random random(12);
  const Layout of{
      .stands = 6, .plots = 4, .trees = 3, .sd_stand = 2.0, .sd_plot = 1.0, .sd_tree = 0.5};
  Table table = layout(of, random);
  // Balanced: the same in each stand, with mean 0 and sum of squares 10 there.
  const std::vector<double> of_plot{-2.0, -1.0, 1.0, 2.0};
  std::vector<double> w;
  for (std::size_t row = 0; row < table.rows(); ++row) w.push_back(of_plot[row / 3 % 4]);
  table.set("w", w);
  const FittedModel fit = fitted(table, "y ~ a + b*w", "a | stand/plot");
  const MeanSquare stands = mean_square(table, 12, 72);
  MeanSquare plots = mean_square(table, 3, 12);
  const auto y = table.numbers("y");
  const double squares = 3.0 * 6.0 * 10.0;
  double slope = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) slope += w[row] * y[row] / squares;
  plots.value = (plots.value * plots.freedom - slope * slope * squares) / (plots.freedom - 1.0);
  plots.freedom -= 1.0;
  REQUIRE(stands.value > plots.value);
  REQUIRE(plots.value > mean_square(table, 1, 3).value);
  const double at_w = 6.0;
  Table at;
  at.set("w", std::vector<double>{at_w});
  const double expected = satterthwaite({{1.0 / 72.0, stands}, {at_w * at_w / squares, plots}});
  CHECK(population(fit, IntervalKind::kConfidence, at).degrees_of_freedom[0] ==
        Approx(expected).epsilon(kSearch));
}

TEST_CASE("a fit without degrees of freedom of sigma has no intervals of width zero") {
  Table table;
  table.set("x", std::vector<double>{1.0, 2.0, 3.0});
  table.set("y", std::vector<double>{2.0, 3.5, 5.5});
  ModelSpecification model = specify_model("y ~ a + b*x + c*x^2", {}, table);
  const FittedModel fit = fit_model(model, table).fit;
  const Prediction mean = population(fit, IntervalKind::kConfidence);
  CHECK(std::isfinite(mean.value[0]));
  CHECK(std::isnan(mean.mean_error[0]));
  CHECK(std::isnan(mean.lower[0]));
  CHECK(std::isnan(mean.upper[0]));
}

TEST_CASE("intervals from four plots have their stated coverage", "[slow]") {
  // Plots differ ten times as much as trees, so that the t distribution with three degrees of
  // freedom is all but exact for a tree of another plot. Restricted likelihood: the variances have
  // no bias.
  Random random(17);
  constexpr int kFits = 4000;
  constexpr int kPlots = 4;
  constexpr int kTrees = 6;
  constexpr double kCoverage = 0.95;
  TextColumn plot;
  for (int row = 0; row < kPlots * kTrees; ++row) plot.append(fmt::format("P{}", row / kTrees));
  int new_plot = 0;
  int mean = 0;
  int same_plot = 0;
  for (int i = 0; i < kFits; ++i) {
    std::vector<double> y;
    double effect = 0.0;
    for (int row = 0; row < kPlots * kTrees; ++row) {
      if (row % kTrees == 0) effect = random.normal(0.0, 3.0);
      y.push_back(20.0 + effect + random.normal(0.0, 0.3));
    }
    Table table;
    table.set("plot", plot);
    table.set("y", y);
    table.set("x", std::vector<double>(y.size(), 0.0));
    const FittedModel fit = fitted(table, "y ~ mu + 0*x", "mu | plot");
    const auto holds = [](const Prediction& prediction, double value) {
      return prediction.lower[0] <= value && value <= prediction.upper[0] ? 1 : 0;
    };
    new_plot += holds(population(fit), 20.0 + random.normal(0.0, std::hypot(3.0, 0.3)));
    mean += holds(population(fit, IntervalKind::kConfidence), 20.0);
    TextColumn last;
    last.append(fmt::format("P{}", kPlots - 1));
    Table one = one_row();
    one.set("plot", last);
    same_plot += holds(predict(fit, one, Level::kConditional, {.interval = kCoverage}),
                       20.0 + effect + random.normal(0.0, 0.3));
  }
  // Four standard errors of a share among the fits.
  const double tolerance = 4.0 * std::sqrt(kCoverage * (1.0 - kCoverage) / kFits);
  CHECK(new_plot / double{kFits} == Approx(kCoverage).margin(tolerance));
  CHECK(mean / double{kFits} == Approx(kCoverage).margin(tolerance));
  CHECK(same_plot / double{kFits} == Approx(kCoverage).margin(tolerance));
}
