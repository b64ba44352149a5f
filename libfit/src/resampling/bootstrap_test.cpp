// SPDX-License-Identifier: MIT
#include "silvafit/fit/bootstrap.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/parameter_values.hpp"
#include "test_support/nested_trees.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

constexpr int kGroups = 12;
constexpr int kRows = 8;

/// A balanced one-way layout with large differences between groups.
data::Table one_way() {
  Random random(41);
  data::Table table;
  data::TextColumn plot;
  std::vector<double> y;
  for (int i = 0; i < kGroups; ++i) {
    const double effect = random.normal(0.0, 3.0);
    for (int j = 0; j < kRows; ++j) {
      plot.append("p" + std::to_string(i));
      y.push_back(10.0 + effect + random.normal(0.0, 1.0));
    }
  }
  table.set("plot", plot);
  table.set("y", y);
  return table;
}

FittedModel one_way_fit(const data::Table& table) {
  ModelSpecification model = specify_model("y ~ mu", {}, table);
  add_random_effects(model, "mu | plot", table);
  return fit_model(model, table).fit;
}

const BootstrapParameter& named(const Bootstrap& bootstrap, const std::string& name) {
  for (const BootstrapParameter& parameter : bootstrap.parameters) {
    if (parameter.name == name) return parameter;
  }
  FAIL("no parameter " << name);
  return bootstrap.parameters.front();
}

/// Four standard errors of a standard deviation from R normal replicates, relative to it.
double monte_carlo(std::size_t replicates) {
  return 4.0 / std::sqrt(2.0 * static_cast<double>(replicates));
}

data::Table stands() {
  return data::read_csv_table(test::source_file("tests/reference/data/stands.csv"));
}

FittedModel stands_fit(const data::Table& table, const char* random, Method method) {
  ModelSpecification model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table);
  add_random_effects(model, random, table);
  model.variance = parse_variance_function("power");
  return fit_model(model, table, {.method = method}).fit;
}

}  // namespace

TEST_CASE("the parametric bootstrap has the standard errors of linear mixed model theory") {
  // Balanced one-way layout: the mean of all is normal with variance (psi + sigma^2/n)/G, and the
  // estimate of sigma^2 is chi-squared with G(n - 1) degrees of freedom.
  const data::Table table = one_way();
  const FittedModel fit = one_way_fit(table);
  const std::size_t count = 1000;
  const Bootstrap result = bootstrap(fit, table, {.replicates = count, .seed = 3});
  REQUIRE(result.converged == count);
  const double sigma2 = fit.sigma * fit.sigma;
  const double psi = fit.random.back().covariance(0, 0);
  const double error = std::sqrt((psi + sigma2 / kRows) / kGroups);
  const BootstrapParameter& mean = named(result, "mu");
  CHECK(mean.estimate == fit.estimate[0]);
  CHECK(mean.replicates == count);
  CHECK(mean.standard_error == Approx(error).epsilon(monte_carlo(count)));
  const double error_of_mean = error / std::sqrt(static_cast<double>(count));
  CHECK(mean.bias == Approx(0.0).margin(4.0 * error_of_mean));
  // A normal quantile at 2.5 % from R replicates has a standard error of 2.67 / sqrt(R) sd.
  const double margin = 4.0 * 2.67 * error_of_mean;
  CHECK(mean.percentile.low == Approx(mean.estimate - 1.96 * error).margin(margin));
  CHECK(mean.percentile.high == Approx(mean.estimate + 1.96 * error).margin(margin));
  CHECK(mean.basic.low == 2.0 * mean.estimate - mean.percentile.high);
  CHECK(mean.basic.high == 2.0 * mean.estimate - mean.percentile.low);
  // sd of the root of a chi-squared over its degrees of freedom, to second order.
  const double freedom = kGroups * (kRows - 1);
  CHECK(named(result, "sigma").standard_error ==
        Approx(fit.sigma / std::sqrt(2.0 * freedom)).epsilon(monte_carlo(count) + 1.0 / freedom));
  // The estimate of psi + sigma^2/n is (psi + sigma^2/n) times chi-squared(G - 1) over G, so that
  // that of its root is too small on average; sigma^2/n is next to nothing here.
  const BootstrapParameter& sd = named(result, "sd(mu)");
  const double half = 0.5 * (kGroups - 1);
  const double shrinkage =
      std::sqrt(2.0 / kGroups) * std::exp(std::lgamma(half + 0.5) - std::lgamma(half));
  CHECK(sd.bias == Approx((shrinkage - 1.0) * sd.estimate)
                       .margin(4.0 * sd.standard_error / std::sqrt(1.0 * count)));
}

TEST_CASE("the cases bootstrap draws whole groups") {
  // The mean of G balanced groups drawn with replacement has the variance of the group means,
  // divisor G, over G.
  const data::Table table = one_way();
  const FittedModel fit = one_way_fit(table);
  const std::size_t count = 1000;
  const Bootstrap result =
      bootstrap(fit, table, {.replicates = count, .resample = Resample::kCases, .seed = 4});
  REQUIRE(result.converged == count);
  const auto y = table.numbers("y");
  double squares = 0.0;
  for (std::size_t i = 0; i < kGroups; ++i) {
    double group = 0.0;
    for (std::size_t j = 0; j < kRows; ++j) group += y[i * kRows + j] / kRows;
    squares += std::pow(group - fit.estimate[0], 2);
  }
  CHECK(named(result, "mu").standard_error ==
        Approx(std::sqrt(squares / kGroups / kGroups)).epsilon(monte_carlo(count)));
}

TEST_CASE("the parametric bootstrap agrees with Wald's standard errors on much data", "[slow]") {
  const data::Table table = stands();
  for (const Method method : {Method::kLindstromBates, Method::kLaplace}) {
    const FittedModel fit = stands_fit(table, "a | plot", method);
    const std::size_t count = 400;
    const Bootstrap result = bootstrap(fit, table, {.replicates = count});
    CHECK(result.converged == count);
    for (Eigen::Index k = 0; k < fit.estimate.size(); ++k) {
      // Wald's are those of an infinite sample; 32 plots leave some hundredths.
      CHECK(result.parameters[static_cast<std::size_t>(k)].standard_error ==
            Approx(fit.standard_errors()[k]).epsilon(monte_carlo(count) + 0.03));
    }
  }
}

TEST_CASE("replicates do not depend on the number of threads") {
  const data::Table table = stands();
  const FittedModel nested = stands_fit(table, "a | stand/number", Method::kLindstromBates);
  REQUIRE(nested.convergence.converged());
  for (const Resample resample : {Resample::kParametric, Resample::kCases}) {
    const BootstrapOptions options{.replicates = 12, .resample = resample, .seed = 9, .threads = 1};
    BootstrapOptions parallel = options;
    parallel.threads = 2;
    const Bootstrap one = bootstrap(nested, table, options);
    const Bootstrap two = bootstrap(nested, table, parallel);
    REQUIRE(one.values.size() == two.values.size());
    CHECK(one.converged > 0);
    const auto bytes = sizeof(double) * static_cast<std::size_t>(one.values.size());
    CHECK(std::memcmp(one.values.data(), two.values.data(), bytes) == 0);
    BootstrapOptions other = options;
    other.seed = 10;
    CHECK(bootstrap(nested, table, other).values(0, 0) != one.values(0, 0));
  }
}

TEST_CASE("replicates without a fit are counted with their reason") {
  // Of three rows, all three draws are the same one in 1/9 of the replicates: no line goes through.
  data::Table table;
  table.set("x", std::vector<double>{1.0, 2.0, 4.0});
  table.set("y", std::vector<double>{1.0, 2.5, 3.0});
  const FittedModel fit = fit_model(specify_model("y ~ a*exp(b*x)", {}, table), table).fit;
  REQUIRE(fit.convergence.converged());
  const std::size_t count = 300;
  const Bootstrap result =
      bootstrap(fit, table, {.replicates = count, .resample = Resample::kCases});
  std::size_t failed = 0;
  for (const CountedReason& failure : result.failures) {
    CHECK_FALSE(failure.reason.empty());
    failed += failure.replicates;
  }
  CHECK(result.converged + failed == count);
  CHECK(failed > 10);
  CHECK(named(result, "b").replicates == result.converged);
}

TEST_CASE("drawn groups have the names of the file in reasons of failure") {
  // Of three stands, one of two plots and two of one, a third of the draws has no stand of two.
  Random random(6);
  data::Table table;
  data::TextColumn stand;
  data::TextColumn plot;
  std::vector<double> y;
  for (const int of : {0, 0, 1, 2}) {
    const double effect = random.normal(0.0, 2.0);
    for (int tree = 0; tree < 6; ++tree) {
      stand.append("s" + std::to_string(of));
      plot.append(std::to_string(y.size() / 6));
      y.push_back(10.0 + effect + random.normal());
    }
  }
  table.set("stand", stand);
  table.set("plot", plot);
  table.set("y", y);
  table.set("x", std::vector<double>(y.size(), 0.0));
  ModelSpecification model = specify_model("y ~ a + 0*x", {}, table);
  add_random_effects(model, "a | stand/plot", table);
  const FittedModel fit = fit_model(model, table).fit;
  REQUIRE(fit.convergence.converged());
  const Bootstrap result = bootstrap(fit, table, {.replicates = 40, .resample = Resample::kCases});
  bool names_stands = false;
  for (const CountedReason& failure : result.failures) {
    CHECK(failure.reason.find("drawn") == std::string::npos);
    names_stands = names_stands || failure.reason.find("| stand)") != std::string::npos;
  }
  CHECK(names_stands);
}

TEST_CASE("parameters have their reported names") {
  const data::Table table = stands();
  const FittedModel fit = stands_fit(table, "a + b | stand/number", Method::kLindstromBates);
  std::vector<std::string> names;
  for (const NamedValue& value : parameter_values(fit)) names.push_back(value.name);
  CHECK(names == std::vector<std::string>{"a",
                                          "b",
                                          "sd(a | stand)",
                                          "sd(b | stand)",
                                          "cor(a, b | stand)",
                                          "sd(a | number)",
                                          "sd(b | number)",
                                          "cor(a, b | number)",
                                          "delta",
                                          "sigma"});
  CHECK(static_cast<int>(names.size()) == fit.parameter_count);
}

TEST_CASE("impossible bootstraps are refused") {
  const data::Table table = one_way();
  FittedModel fit = one_way_fit(table);
  CHECK_THROWS_AS(bootstrap(fit, table, {.replicates = 1}), UsageError);
  CHECK_THROWS_AS(bootstrap(fit, table, {.level = 1.0}), UsageError);
  CHECK_THROWS_WITH(value_of<Resample>("residuals", "kind of resampling"),
                    Contains("available: parametric, cases"));
  fit.convergence.status = ConvergenceStatus::kDiverged;
  CHECK_THROWS_WITH(bootstrap(fit, table), Contains("has not converged"));
}

namespace {

/// Plots of 20 trees, half of one species and half of the other, whose heights spread twice as
/// much; pines grow in the first plots only if asked for.
data::Table two_species(int plots, int plots_with_pine) {
  Random random(6);
  data::Table table;
  data::TextColumn plot;
  data::TextColumn species;
  std::vector<double> y;
  for (int i = 0; i < plots; ++i) {
    for (int j = 0; j < 20; ++j) {
      const bool is_pine = i < plots_with_pine && j % 2 == 0;
      plot.append("p" + std::to_string(i));
      species.append(is_pine ? "pine" : "oak");
      y.push_back(10.0 + random.normal(0.0, is_pine ? 1.0 : 2.0));
    }
  }
  table.set("plot", plot);
  table.set("species", species);
  table.set("y", y);
  return table;
}

FittedModel two_species_fit(const data::Table& table) {
  ModelSpecification model = specify_model("y ~ mu", {}, table);
  model.variance = parse_variance_function("stratum(species)");
  return fit_model(model, table).fit;
}

bool has_parameter(const Bootstrap& bootstrap, const std::string& name) {
  return std::ranges::find(bootstrap.parameters, name, &BootstrapParameter::name) !=
         bootstrap.parameters.end();
}

}  // namespace

TEST_CASE("ratios of strata keep their reference for any order of strata in a replicate") {
  const data::Table table = two_species(10, 10);
  const FittedModel fit = two_species_fit(table);
  REQUIRE(fit.convergence.converged());
  REQUIRE(fit.variance.factors[0].strata.front() == "pine");
  const std::size_t count = 1000;
  const Bootstrap result =
      bootstrap(fit, table, {.replicates = count, .resample = Resample::kCases, .seed = 2});
  REQUIRE(result.converged == count);
  // One by definition, so no estimate.
  CHECK_FALSE(has_parameter(result, "ratio of pine"));
  CHECK(static_cast<int>(result.parameters.size()) == fit.parameter_count);
  // The standard deviation of n rows has the variance sigma^2 (kurtosis - 1)/(4 n); of the ratio
  // the relative variances add up. What is known of the mean from both species costs less than a
  // row of 100, and the number of pines, which varies by a tenth, less than a hundredth.
  const auto y = table.numbers("y");
  const data::TextColumn species = table.labels("species");
  const auto relative_variance = [&](const char* name) {
    double second = 0.0;
    double fourth = 0.0;
    double n = 0.0;
    for (std::size_t row = 0; row < y.size(); ++row) {
      if (species[row] != name) continue;
      const double square = std::pow(y[row] - fit.estimate[0], 2);
      second += square;
      fourth += square * square;
      n += 1.0;
    }
    return (n * fourth / (second * second) - 1.0) / (4.0 * n);
  };
  const double pine = relative_variance("pine");
  const double oak = relative_variance("oak");
  const BootstrapParameter& sigma = named(result, "sigma");
  const BootstrapParameter& ratio = named(result, "ratio of oak");
  const double tolerance = monte_carlo(count) + 0.02;
  CHECK(sigma.standard_error == Approx(fit.sigma * std::sqrt(pine)).epsilon(tolerance));
  CHECK(ratio.standard_error == Approx(ratio.estimate * std::sqrt(pine + oak)).epsilon(tolerance));
  // The bias is of second order: of the size of these relative variances.
  CHECK(sigma.bias == Approx(0.0).margin(2.0 * pine * fit.sigma));
  CHECK(ratio.bias == Approx(0.0).margin(2.0 * (pine + oak) * ratio.estimate));
}

TEST_CASE("a replicate without the stratum that ratios relate to has none, nor a sigma") {
  const data::Table table = two_species(6, 2);
  const FittedModel fit = two_species_fit(table);
  REQUIRE(fit.convergence.converged());
  const std::size_t count = 1000;
  const Bootstrap result = bootstrap(
      fit, table, {.replicates = count, .resample = Resample::kCases, .seed = 3, .group = "plot"});
  REQUIRE(result.converged == count);
  CHECK(named(result, "mu").replicates == count);
  CHECK(named(result, "sigma").replicates == named(result, "ratio of oak").replicates);
  // None of six draws is one of the two plots with pines.
  const double share = std::pow(4.0 / 6.0, 6);
  const double without =
      1.0 - static_cast<double>(named(result, "sigma").replicates) / static_cast<double>(count);
  const double error = std::sqrt(share * (1.0 - share) / static_cast<double>(count));
  CHECK(without == Approx(share).margin(4.0 * error));
}

TEST_CASE("cases of nested groups give each standard deviation its values") {
  Random random(12);
  std::vector<NestedTree> trees;
  for (int s = 0; s < 12; ++s) {
    const double of_stand = random.normal(0.0, 3.0);
    for (int p = 0; p < 4; ++p) {
      const double of_plot = random.normal(0.0, 1.5);
      for (int i = 0; i < 6; ++i) {
        trees.push_back({.stand = std::to_string(s), .plot = std::to_string(p), .species = "fir"});
        trees.back().h_m = 20.0 + of_stand + of_plot + random.normal();
      }
    }
  }
  const data::Table table = table_of(trees);
  ModelSpecification model = specify_model("h ~ mu", {}, table);
  add_random_effects(model, "mu | stand/plot", table);
  const FittedModel fit = fit_model(model, table, {}).fit;
  const Bootstrap result =
      bootstrap(fit, table, {.replicates = 60, .resample = Resample::kCases, .seed = 3});
  for (const BootstrapParameter& parameter : result.parameters) {
    CAPTURE(parameter.name);
    CHECK(parameter.replicates == result.converged);
  }
  // The mean of balanced stands drawn with replacement has the variance of their means over S.
  double squares = 0.0;
  for (std::size_t s = 0; s < 12; ++s) {
    double mean = 0.0;
    for (std::size_t i = 0; i < 24; ++i) mean += trees[24 * s + i].h_m / 24.0;
    squares += std::pow(mean - fit.estimate[0], 2);
  }
  CHECK(named(result, "mu").standard_error ==
        Approx(std::sqrt(squares) / 12.0).epsilon(monte_carlo(60)));
}

TEST_CASE("cases may be drawn of a coarser grouping than that of the random effects") {
  data::Table table = one_way();
  data::TextColumn stand;
  data::TextColumn half;
  for (int row = 0; row < kGroups * kRows; ++row) {
    stand.append("s" + std::to_string(row / kRows / 2));
    half.append(row % 2 == 0 ? "even" : "odd");
  }
  table.set("stand", stand);
  table.set("half", half);
  const FittedModel fit = one_way_fit(table);
  BootstrapOptions options{
      .replicates = 1000, .resample = Resample::kCases, .seed = 4, .group = "stand"};
  const Bootstrap result = bootstrap(fit, table, options);
  REQUIRE(result.converged == options.replicates);
  // The mean of six stands of equal size drawn with replacement.
  const auto y = table.numbers("y");
  constexpr int kStands = kGroups / 2;
  constexpr std::size_t kTrees = std::size_t{2} * kRows;  // a stand
  double squares = 0.0;
  for (std::size_t i = 0; i < kStands; ++i) {
    double mean = 0.0;
    for (std::size_t j = 0; j < kTrees; ++j) mean += y[i * kTrees + j] / kTrees;
    squares += std::pow(mean - fit.estimate[0], 2);
  }
  CHECK(named(result, "mu").standard_error ==
        Approx(std::sqrt(squares / kStands / kStands)).epsilon(monte_carlo(options.replicates)));
  // Draws of the grouping itself are what they are without a name.
  options.replicates = 5;
  options.group = "plot";
  const Bootstrap named_plots = bootstrap(fit, table, options);
  options.group.clear();
  CHECK(named_plots.values == bootstrap(fit, table, options).values);

  options.group = "half";
  CHECK_THROWS_WITH(bootstrap(fit, table, options), Contains("name a coarser grouping"));
  options.group = "nosuch";
  CHECK_THROWS_WITH(bootstrap(fit, table, options), Contains("nosuch"));
  options.group = "stand";
  options.resample = Resample::kParametric;
  CHECK_THROWS_WITH(bootstrap(fit, table, options), Contains("draws no groups"));
}
