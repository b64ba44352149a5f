// SPDX-License-Identifier: MIT
#include "prediction/neighbor_residuals.hpp"

#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"

using namespace silvafit::fit;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::data::Table;

namespace {

constexpr std::size_t kRows = 8;

/// Straight lines with an effect of each group, and residuals with correlation 0.8^distance.
Table lines(int groups, std::uint64_t seed) {
  silvafit::Random random(seed, 0);
  std::vector<double> group;
  std::vector<double> time;
  std::vector<double> y;
  for (int g = 0; g < groups; ++g) {
    const double effect = 3.0 * random.normal();
    double at = random.uniform(1.0, 3.0);
    double residual = random.normal();
    for (std::size_t i = 0; i < kRows; ++i) {
      group.push_back(g);
      time.push_back(at);
      y.push_back(5.0 + effect + 0.5 * at + residual);
      const double step = random.uniform(0.5, 3.0);
      const double phi = std::pow(0.8, step);
      residual = phi * residual + std::sqrt(1.0 - phi * phi) * random.normal();
      at += step;
    }
  }
  Table table(y.size());
  table.set("g", group);
  table.set("t", time);
  table.set("y", y);
  return table;
}

}  // namespace

TEST_CASE("errors of predictions from measured neighbors are those of universal kriging") {
  const Table data = lines(20, 7);
  const FittedModel fit =
      fit_model(
          specify_model(
              ModelTexts{.formula = "y ~ a + b*t", .random = "a | g", .correlation = "car1(t)"},
              data),
          data)
          .fit;
  REQUIRE(fit.convergence.status == ConvergenceStatus::kConverged);
  Table table = lines(1, 8);
  table.set("g", std::vector<double>(kRows, 99.0));
  std::vector<double> response(table.numbers("y").begin(), table.numbers("y").end());
  const std::vector<Index> hidden{1, 4, 7};
  const std::vector<Index> measured{0, 2, 3, 5, 6};
  for (const Index row : hidden) response[static_cast<std::size_t>(row)] = silvafit::kNaN;
  table.set("y", response);

  const VectorXd time = Eigen::Map<const VectorXd>(table.numbers("t").data(), kRows);
  const VectorXd y = Eigen::Map<const VectorXd>(response.data(), kRows);
  MatrixXd x(static_cast<Index>(kRows), 2);
  x << VectorXd::Ones(kRows), time;
  const double phi = fit.variance.correlation->values[0];
  MatrixXd v(x.rows(), x.rows());
  for (Index i = 0; i < v.rows(); ++i) {
    for (Index j = 0; j < v.rows(); ++j) {
      v(i, j) = fit.random[0].covariance(0, 0) +
                fit.sigma * fit.sigma * std::pow(phi, std::abs(time[i] - time[j]));
    }
  }
  const MatrixXd weights = v(hidden, measured) * v(measured, measured).inverse();
  const VectorXd expected = x(hidden, Eigen::all) * fit.estimate +
                            weights * (y(measured) - x(measured, Eigen::all) * fit.estimate);
  const MatrixXd slopes = x(hidden, Eigen::all) - weights * x(measured, Eigen::all);
  const MatrixXd variance = slopes * fit.covariance * slopes.transpose() + v(hidden, hidden) -
                            weights * v(measured, hidden);

  for (const IntervalKind kind : {IntervalKind::kPrediction, IntervalKind::kConfidence}) {
    const Prediction found =
        predict(fit, table, Level::kCalibrated, {.interval = 0.9, .interval_kind = kind});
    for (Index k = 0; k < std::ssize(hidden); ++k) {
      const Index row = hidden[static_cast<std::size_t>(k)];
      CHECK(found.value[row] == Approx(expected[k]).epsilon(1e-9));
      CHECK(found.prediction_error[row] == Approx(std::sqrt(variance(k, k))).epsilon(1e-9));
      CHECK(found.mean_error[row] < found.prediction_error[row]);
      const double error =
          kind == IntervalKind::kPrediction ? found.prediction_error[row] : found.mean_error[row];
      // The quantile of t is slightly above that of the normal distribution.
      CHECK((found.upper[row] - found.value[row]) / error > 1.6448);
      CHECK((found.upper[row] - found.value[row]) / error < 1.68);
      CHECK(found.upper[row] - found.value[row] ==
            Approx(found.value[row] - found.lower[row]).epsilon(1e-12));
    }
  }
}

TEST_CASE("a group too large for its negative correlation has no predictions, with the reason") {
  // The variance of a sum of n standardized residuals is n (1 + (n - 1) rho): with rho = -0.15 the
  // largest group has 7 rows.
  const Table data = lines(20, 7);
  FittedModel fit = fit_model(specify_model(ModelTexts{.formula = "y ~ a + b*t",
                                                       .correlation = "compound-symmetry(1 | g)"},
                                            data),
                              data)
                        .fit;
  REQUIRE(fit.variance.correlation);
  fit.variance.correlation->values[0] = -0.15;
  fit.variance.correlation->largest = 7;
  CHECK(group_gap(*fit.variance.correlation, 7).empty());
  CHECK_FALSE(group_gap(*fit.variance.correlation, 8).empty());
  for (const std::size_t measured : {6, 7}) {
    Table table = lines(1, 8);
    std::vector<double> y(table.numbers("y").begin(), table.numbers("y").end());
    for (std::size_t row = measured; row < kRows; ++row) y[row] = silvafit::kNaN;
    table.set("y", y);
    const Prediction found = predict(fit, table, Level::kCalibrated, {.interval = 0.9});
    const auto last = static_cast<Index>(kRows) - 1;
    CHECK(std::isfinite(found.value[last]) == (measured == 6));
    CHECK(std::isfinite(found.upper[last]) == (measured == 6));
    CHECK(found.value_gap.back().empty() == (measured == 6));
  }
}
