// SPDX-License-Identifier: MIT
// Effects of crossed groups, known and new ones, against Henderson's dense equations.
#include <fmt/format.h>

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <map>
#include <string>
#include <vector>

#include "silvafit/base/random.hpp"
#include "silvafit/fit/calibration.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/prediction.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::Random;
using silvafit::data::Table;
using silvafit::data::TextColumn;
using namespace silvafit::fit;
using Catch::Matchers::Contains;

namespace {

struct Row {
  int plot = 0;
  int year = 0;
  double x = 0.0;
  double y = silvafit::kNaN;
};

Table table_of(const std::vector<Row>& rows) {
  TextColumn plots;
  TextColumn years;
  std::vector<double> x;
  std::vector<double> y;
  for (const Row& row : rows) {
    plots.append(fmt::format("P{}", row.plot));
    years.append(fmt::format("Y{}", row.year));
    x.push_back(row.x);
    y.push_back(row.y);
  }
  Table table(rows.size());
  table.set("plot", plots);
  table.set("year", years);
  table.set("x", x);
  table.set("y", y);
  return table;
}

/// Observations of plots in years, with an effect of each on the intercept and of plots also on the
/// slope. Not every plot was visited in every year.
struct Visits {
  std::vector<Row> rows{};
  std::map<int, double> of_year{};
};

Visits visits(int plots, int first_year, int last_year, Random& random, Visits result = {}) {
  for (int year = first_year; year <= last_year; ++year) {
    result.of_year.emplace(year, random.normal(0.0, 0.7));
  }
  const int first = result.rows.empty() ? 0 : 100;
  for (int plot = first; plot < first + plots; ++plot) {
    const double level = random.normal(0.0, 1.2);
    const double slope = random.normal(0.0, 0.3);
    for (int year = first_year; year <= last_year; ++year) {
      if ((plot + 2 * year) % 3 == 0) continue;
      for (int k = 0; k < 2; ++k) {
        const double x = random.uniform(-1.0, 3.0);
        const double mean = 4.0 + level + result.of_year.at(year) + (1.5 + slope) * x;
        result.rows.push_back(
            {.plot = plot, .year = year, .x = x, .y = mean + random.normal(0.0, 0.5)});
      }
    }
  }
  return result;
}

FittedModel fitted(const Table& table, Method method) {
  ModelSpecification model = specify_model("y ~ a + b*x", {}, table);
  add_random_effects(model, "(a + b | plot) + (a | year)", table);
  FittedModel fit = fit_model(model, table, {.method = method}).fit;
  INFO(fit.convergence.verdict());
  REQUIRE(fit.convergence.converged());
  return fit;
}

/// Henderson's equations at a fit's estimates, for effects of 2 plots' and 1 years' kinds.
class Dense {
 public:
  Dense(const FittedModel& fit, const std::vector<Row>& rows) : fit_(fit) {
    for (const Row& row : rows) {
      plots_.emplace(row.plot, 0);
      years_.emplace(row.year, 0);
    }
    Index place = 0;
    for (auto& [plot, at] : plots_) {
      at = place;
      place += 2;
    }
    for (auto& [year, at] : years_) at = place++;
    const auto n = static_cast<Index>(rows.size());
    MatrixXd x(n, 2);
    MatrixXd z = MatrixXd::Zero(n, place);
    VectorXd y(n);
    for (Index i = 0; i < n; ++i) {
      const Row& row = rows[static_cast<std::size_t>(i)];
      x.row(i) << 1.0, row.x;
      z.row(i) = incidence(row).transpose();
      y[i] = row.y;
    }
    MatrixXd prior = MatrixXd::Zero(place, place);
    for (const auto& [plot, at] : plots_) prior.block(at, at, 2, 2) = fit.random[0].covariance;
    for (const auto& [year, at] : years_) prior(at, at) = fit.random[1].covariance(0, 0);
    const double variance = fit.sigma * fit.sigma;
    covariance_ = (z.transpose() * z / variance + prior.inverse()).inverse();
    effects_ = covariance_ * z.transpose() * (y - x * fit.estimate) / variance;
    follow_ = -covariance_ * z.transpose() * x / variance;
  }

  double value(const Row& row) const {
    return fit_.estimate[0] + fit_.estimate[1] * row.x + incidence(row).dot(effects_);
  }
  /// Standard error of the mean; new groups have the variance of their effects beside it.
  double error(const Row& row) const {
    const VectorXd z = incidence(row);
    const VectorXd x = Eigen::Vector2d(1.0, row.x) + follow_.transpose() * z;
    return std::sqrt(x.dot(fit_.covariance * x) + z.dot(covariance_ * z));
  }

 private:
  VectorXd incidence(const Row& row) const {
    VectorXd result = VectorXd::Zero(2 * std::ssize(plots_) + std::ssize(years_));
    if (const auto found = plots_.find(row.plot); found != plots_.end()) {
      result.segment(found->second, 2) << 1.0, row.x;
    }
    if (const auto found = years_.find(row.year); found != years_.end()) {
      result[found->second] = 1.0;
    }
    return result;
  }

  const FittedModel& fit_;
  std::map<int, Index> plots_;
  std::map<int, Index> years_;
  MatrixXd covariance_;
  VectorXd effects_;
  MatrixXd follow_;
};

/// Effects are found to 1e-9 standard deviations; errors follow from factorized matrices.
constexpr double kTolerance = 1e-8;

void check(const Prediction& found, const Dense& expected, const std::vector<Row>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    INFO("plot " << rows[i].plot << " year " << rows[i].year);
    const auto at = static_cast<Index>(i);
    CHECK(found.value[at] == Approx(expected.value(rows[i])).epsilon(kTolerance));
    CHECK(found.mean_error[at] == Approx(expected.error(rows[i])).epsilon(kTolerance));
  }
}

}  // namespace

TEST_CASE("conditional errors with crossed groups are those of Henderson's equations") {
  Random random(8);
  const Visits data = visits(9, 1, 6, random);
  // The first row's plot was not visited in that year, the last one's plot is new.
  const std::vector<Row> rows{{0, 3, 0.4}, {0, 1, 2.0}, {5, 4, -0.5}, {77, 2, 1.0}};
  for (const Method method : {Method::kLindstromBates, Method::kInteraction, Method::kLaplace}) {
    const FittedModel fit = fitted(table_of(data.rows), method);
    const FittedModel stored = from_json(to_json(fit), "fit.json");
    const Prediction found =
        predict(stored, table_of(rows), Level::kConditional, {.interval = 0.9});
    check(found, Dense(fit, data.rows), rows);
    // The effects of a new plot are open: their variance is part of that of a new value.
    const Index last = std::ssize(rows) - 1;
    const Eigen::Vector2d z(1.0, rows.back().x);
    const double open = z.dot(fit.random[0].covariance * z);
    const double error = std::hypot(found.mean_error[last], std::sqrt(open), fit.sigma);
    CHECK(found.prediction_error[last] == Approx(error).epsilon(1e-12));
    CHECK(found.upper[last] > found.value[last] + 1.6 * error);
    const Prediction marginal =
        predict(fit, table_of(rows), Level::kConditional, {.new_groups = NewGroups::kMarginal});
    CHECK(marginal.value.isApprox(found.value, 1e-12));  // the mean is linear
  }
}

TEST_CASE("crossed groups are calibrated with the fit's data and the trees of the table") {
  Random random(8);
  const Visits data = visits(9, 1, 6, random);
  const FittedModel fit =
      from_json(to_json(fitted(table_of(data.rows), Method::kInteraction)), "fit.json");
  // Three new plots, in known years and in a new one.
  Visits more = visits(3, 5, 7, random, data);
  std::vector<Row> further(more.rows.begin() + std::ssize(data.rows), more.rows.end());
  const std::vector<Row> wanted{{100, 5, 0.4}, {101, 7, 2.0}, {100, 2, 1.0}, {4, 7, -0.5}};
  std::vector<Row> rows = further;
  rows.insert(rows.end(), wanted.begin(), wanted.end());
  const Prediction found =
      predict(fit, table_of(rows), Level::kCalibrated, {.standard_errors = true});
  check(found, Dense(fit, more.rows), rows);
  CHECK(found.calibrated_from.back() == 4);  // of year 7, when two of the new plots were visited

  SECTION("trees whose groups are all in the fit are its own") {
    rows.push_back({4, 5, 1.0, 99.0});
    const Prediction again =
        predict(fit, table_of(rows), Level::kCalibrated, {.standard_errors = true});
    CHECK(again.value.head(found.value.size()) == found.value);
    CHECK(again.calibrated_from.back() == -1);
    check(predict(fit, table_of({rows.back()}), Level::kCalibrated, {.standard_errors = true}),
          Dense(fit, data.rows),
          {rows.back()});
  }
  SECTION("further trees of known groups are combined with those of the fit") {
    further.push_back({4, 5, 1.0, 7.0});
    more.rows.push_back(further.back());
    const Prediction both =
        predict(fit,
                table_of(further),
                Level::kCalibrated,
                {.seen_groups = SeenGroups::kCombined, .standard_errors = true});
    check(both, Dense(fit, more.rows), further);
  }
  SECTION("all groups are new without those of the fit") {
    const Prediction only = predict(fit,
                                    table_of(further),
                                    Level::kCalibrated,
                                    {.seen_groups = SeenGroups::kNew, .standard_errors = true});
    check(only, Dense(fit, further), further);
  }
  SECTION("without a measured tree") {
    const std::vector<Row> unmeasured{{3, 3, 1.0}, {200, 3, 1.0}, {200, 30, 1.0}};
    const Prediction none =
        predict(fit, table_of(unmeasured), Level::kCalibrated, {.standard_errors = true});
    check(none, Dense(fit, data.rows), unmeasured);
    CHECK(none.calibrated_from == std::vector<Index>{-1, 0, 0});
  }
}

TEST_CASE("a fit of an older file has no joint uncertainty of crossed effects") {
  Random random(8);
  FittedModel fit = fitted(table_of(visits(9, 1, 6, random).rows), Method::kInteraction);
  fit.cells = {};
  const Table table = table_of({{0, 3, 0.4}});
  CHECK_THROWS_WITH(predict(fit, table, Level::kConditional, {.interval = 0.9}),
                    Contains("fit the model again"));
  CHECK_THROWS_WITH(calibrate(fit, table), Contains("fit the model again"));
}
