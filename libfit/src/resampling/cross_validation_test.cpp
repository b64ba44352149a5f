// SPDX-License-Identifier: MIT
#include "silvafit/fit/cross_validation.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "reference.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/data/csv.hpp"

using namespace silvafit;
using namespace silvafit::fit;
using Catch::Matchers::Contains;
using Eigen::Index;

namespace {

/// A straight line with 20 rows of their own groups, "r1" to "r20".
data::Table line() {
  Random random(7);
  data::Table table;
  std::vector<double> x;
  std::vector<double> y;
  data::TextColumn row;
  for (int i = 1; i <= 20; ++i) {
    x.push_back(i);
    y.push_back(2.0 + 0.5 * i + random.normal());
    row.append("r" + std::to_string(i));
  }
  table.set("x", x);
  table.set("y", y);
  table.set("row", row);
  return table;
}

data::Table stands_to_leave_out() {
  return data::read_csv_table(test::source_file("tests/reference/data/stands.csv"));
}

FittedModel height_fit(const data::Table& table, const char* random) {
  ModelSpecification model = specify_model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {}, table);
  add_random_effects(model, random, table);
  return fit_model(model, table).fit;
}

}  // namespace

TEST_CASE("rows with a stratum that the other folds lack have no density, and are counted") {
  data::Table table = line();
  data::TextColumn part;
  data::TextColumn kind;
  for (int i = 0; i < 20; ++i) {
    part.append(std::to_string(i / 5));
    // One kind is in the first part only.
    kind.append(i < 5 ? "rare" : (i % 2 == 0 ? "even" : "odd"));
  }
  table.set("part", part);
  table.set("kind", kind);
  ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
  model.variance = parse_variance_function("stratum(kind)");
  const FittedModel fit = fit_model(model, table).fit;
  REQUIRE(fit.convergence.converged());
  const CrossValidation result = cross_validate(fit, table, {.folds = 0, .group = "part"});
  CHECK(result.failed.empty());
  CHECK(result.predicted_count == 20);
  CHECK(result.density_count == 15);
  CHECK(std::isfinite(result.log_density));
}

TEST_CASE("leaving out one observation of a linear model has the closed form of PRESS") {
  // y_i - prediction without i is e_i / (1 - h_i), h the diagonal of the hat matrix.
  const data::Table table = line();
  const FittedModel fit = fit_model(specify_model("y ~ a + b*x", {}, table), table).fit;
  const CrossValidation result = cross_validate(fit, table, {.folds = 0, .group = "row"});
  const Index n = 20;
  Eigen::MatrixXd design(n, 2);
  Eigen::VectorXd y(n);
  for (Index i = 0; i < n; ++i) {
    design.row(i) << 1.0, table.numbers("x")[static_cast<std::size_t>(i)];
    y[i] = table.numbers("y")[static_cast<std::size_t>(i)];
  }
  const Eigen::MatrixXd hat = design * (design.transpose() * design).inverse() * design.transpose();
  const Eigen::VectorXd deleted =
      (y - hat * y).cwiseQuotient(Eigen::VectorXd::Ones(n) - hat.diagonal());
  CHECK(result.folds == 20);
  CHECK(result.groups == 20);
  CHECK(result.predicted_count == 20);
  CHECK(result.failed.empty());
  // Least squares is exact but for rounding.
  CHECK((y - result.predicted - deleted).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(result.statistics.mae == Approx(deleted.cwiseAbs().mean()).epsilon(1e-9));
  // sigma^2 without i, with n - 3 in the denominator.
  double log_density = 0.0;
  const double squares = (y - hat * y).squaredNorm();
  for (Index i = 0; i < n; ++i) {
    const double without = squares - deleted[i] * deleted[i] * (1.0 - hat(i, i));
    const double variance = without / (n - 3.0);
    log_density -=
        0.5 * (std::log(2.0 * std::numbers::pi * variance) + deleted[i] * deleted[i] / variance) /
        n;
  }
  CHECK(result.log_density == Approx(log_density).epsilon(1e-9));
}

TEST_CASE("each prediction is that of a fit without its group") {
  const data::Table table = stands_to_leave_out();
  const FittedModel fit = height_fit(table, "a | plot");
  const CrossValidation result = cross_validate(fit, table, {.folds = 0});
  CHECK(result.group == "plot");
  CHECK(result.folds == 32);
  const data::TextColumn plots = table.labels("plot");
  std::vector<std::size_t> others;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (plots[row] != "S2P3") others.push_back(row);
  }
  const data::Table training = table.select(others);
  const FittedModel without = fit_model(fit.specification, training).fit;
  REQUIRE(without.convergence.converged());
  std::size_t checked = 0;
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    if (plots[result.rows[i]] != "S2P3") continue;
    const double dbh = table.numbers("dbh")[result.rows[i]];
    const double expected =
        1.3 + without.estimate[0] * (1.0 - std::exp(-without.estimate[1] * dbh));
    // Two fits that have converged to within 1e-6 standard errors.
    CHECK(result.predicted[static_cast<Index>(i)] == Approx(expected).epsilon(1e-7));
    ++checked;
  }
  CHECK(checked >= 8);
  CHECK(result.statistics.rmse > fit.conditional.rmse);
}

TEST_CASE("groups are assigned to folds evenly, by the seed, for any number of threads") {
  const data::Table table = stands_to_leave_out();
  const FittedModel fit = height_fit(table, "a | plot");
  CrossValidationOptions options{.folds = 5, .seed = 11, .threads = 1};
  const CrossValidation one = cross_validate(fit, table, options);
  options.threads = 2;
  const CrossValidation two = cross_validate(fit, table, options);
  CHECK(one.fold == two.fold);
  CHECK(one.predicted == two.predicted);
  std::vector<std::set<std::string>> groups(5);
  const data::TextColumn plots = table.labels("plot");
  std::set<std::string> all;
  for (std::size_t i = 0; i < one.rows.size(); ++i) {
    groups[one.fold[i]].insert(std::string(plots[one.rows[i]]));
    all.insert(std::string(plots[one.rows[i]]));
  }
  std::size_t sum = 0;
  for (const auto& fold : groups) {
    CHECK(fold.size() >= 6);
    CHECK(fold.size() <= 7);
    sum += fold.size();
  }
  CHECK(sum == all.size());  // no plot is in two folds
  options.seed = 12;
  CHECK(cross_validate(fit, table, options).fold != one.fold);
}

TEST_CASE("folds that fail are named") {
  // Without group B, a and b are not identifiable.
  data::Table table;
  table.set("x", std::vector<double>{1.0, 1.0, 2.0, 3.0, 4.0});
  table.set("y", std::vector<double>{1.0, 1.4, 2.0, 3.5, 3.9});
  data::TextColumn group;
  for (const char* label : {"A", "A", "B", "B", "B"}) group.append(label);
  table.set("group", group);
  const FittedModel fit = fit_model(specify_model("y ~ a*exp(b*x) + c", {}, table), table).fit;
  const CrossValidation result = cross_validate(fit, table, {.folds = 0, .group = "group"});
  REQUIRE(result.failed.size() == 1);
  CHECK(result.failed[0].groups == std::vector<std::string>{"B"});
  CHECK_FALSE(result.failed[0].verdict.empty());
  CHECK(result.predicted_count == 2);
  CHECK(std::isnan(result.predicted[4]));
}

TEST_CASE("cross-validation needs groups") {
  const data::Table table = line();
  const FittedModel fit = fit_model(specify_model("y ~ a + b*x", {}, table), table).fit;
  CHECK_THROWS_WITH(cross_validate(fit, table), Contains("name their column"));
  data::Table single = table;
  single.set("one", std::vector<double>(20, 1.0));
  CHECK_THROWS_WITH(cross_validate(fit, single, {.group = "one"}), Contains("one has one"));
}

TEST_CASE("calibration with measured trees of a left-out group agrees with BLUP theory") {
  // Random intercepts: the predicted effect of a plot is psi m / (psi m + sigma^2) times the mean
  // residual of its m measured trees from the line.
  const data::Table table = stands_to_leave_out();
  ModelSpecification model = specify_model("h ~ a + b*dbh", {}, table);
  add_random_effects(model, "a | plot", table);
  const FittedModel fit = fit_model(model, table).fit;
  const std::size_t measured = 3;
  const CrossValidation result =
      cross_validate(fit, table, {.folds = 0, .measured = measured, .seed = 5});
  const data::TextColumn plots = table.labels("plot");
  for (const std::string plot : {"S1P1", "S6P2"}) {
    std::vector<std::size_t> others;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (plots[row] != plot) others.push_back(row);
    }
    const data::Table training = table.select(others);
    const FittedModel without = fit_model(model, training).fit;
    double sum = 0.0;
    std::size_t drawn = 0;
    for (std::size_t i = 0; i < result.rows.size(); ++i) {
      if (plots[result.rows[i]] != plot) continue;
      const auto at = static_cast<Index>(i);
      if (!std::isnan(result.calibrated[at])) continue;
      sum += result.observed[at] - result.predicted[at];
      ++drawn;
    }
    REQUIRE(drawn == measured);
    const double psi = without.random.back().covariance(0, 0);
    const double effect = psi * sum / (psi * measured + without.sigma * without.sigma);
    for (std::size_t i = 0; i < result.rows.size(); ++i) {
      const auto at = static_cast<Index>(i);
      if (plots[result.rows[i]] != plot || std::isnan(result.calibrated[at])) continue;
      // Two fits that have converged to within 1e-6 standard errors.
      CHECK(result.calibrated[at] - result.predicted[at] == Approx(effect).margin(1e-5));
    }
  }
  CHECK(result.calibrated_count == table.rows() - 32 * measured);
  CHECK(result.calibrated_statistics.rmse < result.uncalibrated_statistics.rmse);
}

TEST_CASE("calibration of a left-out crossed group agrees with BLUP theory") {
  // A third of the plots' visits is missing; two trees at each.
  Random random(3);
  std::vector<double> of_plot(12);
  std::vector<double> of_year(6);
  for (double& effect : of_plot) effect = random.normal(0.0, 1.2);
  for (double& effect : of_year) effect = random.normal(0.0, 0.7);
  data::TextColumn plots;
  data::TextColumn years;
  std::vector<double> x;
  std::vector<double> y;
  for (std::size_t plot = 0; plot < of_plot.size(); ++plot) {
    for (std::size_t year = 0; year < of_year.size(); ++year) {
      for (int tree = 0; tree < 2 && (plot + 2 * year) % 3 != 0; ++tree) {
        plots.append("P" + std::to_string(plot));
        years.append("Y" + std::to_string(year));
        x.push_back(random.uniform(-1.0, 3.0));
        y.push_back(4.0 + of_plot[plot] + of_year[year] + 1.5 * x.back() + random.normal(0.0, 0.5));
      }
    }
  }
  data::Table table;
  table.set("plot", plots);
  table.set("year", years);
  table.set("x", x);
  table.set("y", y);
  ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
  add_random_effects(model, "a | plot + year", table);
  const FittedModel fit = fit_model(model, table).fit;
  const std::size_t measured = 3;
  const CrossValidation result =
      cross_validate(fit, table, {.folds = 0, .group = "plot", .measured = measured, .seed = 5});
  for (const std::string plot : {"P0", "P7"}) {
    std::vector<std::size_t> others;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (plots[row] != plot) others.push_back(row);
    }
    const FittedModel without = fit_model(model, table.select(others)).fit;
    std::vector<std::size_t> known = others;
    std::vector<Index> predicted;
    for (std::size_t i = 0; i < result.rows.size(); ++i) {
      if (plots[result.rows[i]] != plot) continue;
      const auto at = static_cast<Index>(i);
      std::isnan(result.calibrated[at]) ? known.push_back(result.rows[i]) : predicted.push_back(at);
    }
    REQUIRE(known.size() == others.size() + measured);
    // The effects' best linear prediction from the trees of the fit and the measured ones.
    const double of_plots = without.random[0].covariance(0, 0);
    const double of_years = without.random[1].covariance(0, 0);
    const auto covariance = [&](std::size_t left, std::size_t right) {
      return (plots[left] == plots[right] ? of_plots : 0.0) +
             (years[left] == years[right] ? of_years : 0.0);
    };
    const auto line = [&](std::size_t row) {
      return without.estimate[0] + without.estimate[1] * x[row];
    };
    const auto n = static_cast<Index>(known.size());
    Eigen::MatrixXd v(n, n);
    Eigen::VectorXd residuals(n);
    for (Index i = 0; i < n; ++i) {
      const std::size_t row = known[static_cast<std::size_t>(i)];
      residuals[i] = y[row] - line(row);
      for (Index j = 0; j < n; ++j) {
        v(i, j) = covariance(row, known[static_cast<std::size_t>(j)]);
      }
      v(i, i) += without.sigma * without.sigma;
    }
    const Eigen::VectorXd weights = v.llt().solve(residuals);
    for (const Index at : predicted) {
      const std::size_t row = result.rows[static_cast<std::size_t>(at)];
      double expected = line(row);
      for (Index i = 0; i < n; ++i) {
        expected += weights[i] * covariance(row, known[static_cast<std::size_t>(i)]);
      }
      // Two fits that have converged to within 1e-6 standard errors.
      CHECK(result.calibrated[at] == Approx(expected).margin(1e-5));
    }
  }
  CHECK(result.calibrated_statistics.rmse < result.uncalibrated_statistics.rmse);
}
