// SPDX-License-Identifier: MIT
// Means over plots against theory and fine integration.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "silvafit/fit/prediction.hpp"
#include "test_support/known_fit.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using silvafit::data::Table;
using namespace silvafit::fit;

TEST_CASE("marginal means are the expectations over random effects") {
  SECTION("of an exponential, over two groupings") {
    FittedModel fit = model("y ~ exp(a + 0*x)", {"a"}, "a | stand; a | plot");
    fit.estimate = VectorXd::Constant(1, 0.7);
    fit.random.back().covariance = MatrixXd::Constant(1, 1, 0.09);
    fit.random.front().covariance = MatrixXd::Constant(1, 1, 0.16);
    Table table;
    table.set("x", std::vector<double>{1.0});
    const Prediction prediction = predict(fit, table, Level::kMarginal, {.standard_errors = true});
    CHECK(prediction.value[0] == Approx(std::exp(0.7 + 0.125)).epsilon(1e-9));
    CHECK(prediction.marginal_difference < 1e-8);
  }
  SECTION("of a curve that is not defined at five standard deviations") {
    FittedModel fit = model("h ~ a*(1 - exp(-b*dbh))^1.5", {"a", "b"}, "b | plot");
    fit.estimate = Eigen::Vector2d(25.0, 0.05);
    fit.covariance = MatrixXd::Identity(2, 2) * 1e-4;
    fit.random.back().covariance = MatrixXd::Constant(1, 1, 1e-4);
    Table table;
    table.set("dbh", std::vector<double>{20.0});
    const Prediction prediction = predict(fit, table, Level::kMarginal, {.standard_errors = true});
    // By the trapezoidal rule over positive b; half a millionth of all plots has a negative one.
    double expected = 0.0;
    constexpr double kStep = 1e-3;
    for (double z = -5.0 + kStep; z < 8.0; z += kStep) {
      const double b = 0.05 + 0.01 * z;
      expected += kStep * std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi) * 25.0 *
                  std::pow(1.0 - std::exp(-b * 20.0), 1.5);
    }
    // Seven points are the largest rule within the domain.
    CHECK(prediction.value[0] == Approx(expected).epsilon(1e-5));
    CHECK(prediction.marginal_difference > 1e-8);
    CHECK(prediction.marginal_difference < 1e-3);
    CHECK(prediction.mean_error[0] > 0.0);
  }
  SECTION("of a curve with a pole, around which there is none") {
    FittedModel fit = model("h ~ 1.3 + (dbh/(a*dbh + b))^2", {"a", "b"}, "b | plot");
    fit.estimate = Eigen::Vector2d(0.15, 1.2);
    fit.covariance = MatrixXd::Identity(2, 2) * 1e-6;
    Table table;
    table.set("dbh", std::vector<double>{10.0});
    // E 1/u^2 of a normal u is infinite; the formula's pole is at 2.7 standard deviations.
    fit.random.back().covariance = MatrixXd::Constant(1, 1, 1.0);
    const Prediction none = predict(fit, table, Level::kMarginal, {.standard_errors = true});
    CHECK(std::isnan(none.value[0]));
    CHECK(none.value_gap[0].find("has a pole") != std::string::npos);
    // At 270 standard deviations it does not matter: 1/u^2 (1 + 3 s^2/u^2 + 15 s^4/u^4).
    fit.random.back().covariance = MatrixXd::Constant(1, 1, 1e-4);
    const double share = 1e-4 / (2.7 * 2.7);
    CHECK(predict(fit, table, Level::kMarginal, {}).value[0] ==
          Approx(1.3 + 100.0 / (2.7 * 2.7) * (1.0 + 3.0 * share + 15.0 * share * share))
              .epsilon(1e-10));
  }
  SECTION("of a height curve with two correlated effects") {
    FittedModel fit = model("h ~ 1.3 + a*(1 - exp(-b*dbh))", {"a", "b"}, "a + b | plot");
    fit.estimate = Eigen::Vector2d(25.0, 0.06);
    fit.covariance = Eigen::Matrix2d{{0.3, -5e-4}, {-5e-4, 4e-6}};
    fit.random.back().covariance = Eigen::Matrix2d{{9.0, -0.015}, {-0.015, 2e-4}};
    Table table;
    const std::vector<double> diameters{5.0, 15.0, 40.0};
    table.set("dbh", diameters);
    const Prediction prediction = predict(fit, table, Level::kMarginal, {.standard_errors = true});
    for (std::size_t i = 0; i < diameters.size(); ++i) {
      // E exp(-(b + v) d) = exp(-b d + s^2 d^2 / 2), under which a + u has the mean a - cov(u, v)
      // d.
      const double d = diameters[i];
      const double decay = std::exp(-0.06 * d + 0.5 * 2e-4 * d * d);
      const double expected = 1.3 + 25.0 - (25.0 + 0.015 * d) * decay;
      CHECK(prediction.value[static_cast<Index>(i)] == Approx(expected).epsilon(1e-8));
      const Eigen::Vector2d slope(1.0 - decay, d * (25.0 + 0.015 * d) * decay);
      CHECK(prediction.mean_error[static_cast<Index>(i)] ==
            Approx(std::sqrt(slope.dot(fit.covariance * slope))).epsilon(1e-7));
    }
  }
}
