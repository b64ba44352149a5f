// SPDX-License-Identifier: MIT
#include "least_squares/exchanged_minima.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "silvafit/data/table.hpp"

using Eigen::VectorXd;
using silvafit::data::Table;
using namespace silvafit::fit;

namespace {

NonlinearModel model_of(const char* formula) {
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i < 12; ++i) {
    x.push_back(0.2 + 0.5 * i);
    y.push_back(1.0 / (1.0 + i));
  }
  Table table;
  table.set("x", x);
  table.set("y", y);
  return NonlinearModel(specify_model(formula, {}, table), table);
}

}  // namespace

TEST_CASE("the terms of a biexponential change places") {
  const NonlinearModel model = model_of("y ~ A*exp(-exp(k)*x) + B*exp(-exp(l)*x)");
  const VectorXd minimum = Eigen::Vector4d(2.8, 0.8, 0.5, -1.4);  // A, k, B, l
  const std::vector<VectorXd> found = exchanged_minima(model, minimum);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == VectorXd(Eigen::Vector4d(0.5, -1.4, 2.8, 0.8)));
}

TEST_CASE("the asymptotes of a logistic curve change places with the sign of its slope") {
  const NonlinearModel model = model_of("y ~ B + (A - B)/(1 + exp((x - m)/s))");
  const VectorXd minimum = Eigen::Vector4d(1.6, 28.0, 3.9, -0.25);  // B, A, m, s
  const std::vector<VectorXd> found = exchanged_minima(model, minimum);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == VectorXd(Eigen::Vector4d(28.0, 1.6, 3.9, 0.25)));
}

TEST_CASE("rates of absorption and elimination change places") {
  const NonlinearModel model =
      model_of("y ~ exp(ke + ka - cl)*(exp(-exp(ke)*x) - exp(-exp(ka)*x))/(exp(ka) - exp(ke))");
  const VectorXd minimum = Eigen::Vector3d(-2.4, 0.4, -3.2);  // ke, ka, cl
  const std::vector<VectorXd> found = exchanged_minima(model, minimum);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == VectorXd(Eigen::Vector3d(0.4, -2.4, -3.2)));
}

TEST_CASE("terms of three coefficients change places") {
  const NonlinearModel model =
      model_of("y ~ a1/(1 + exp((b1 - x)/c1)) + a2/(1 + exp((b2 - x)/c2))");
  VectorXd minimum(6);  // a1, b1, c1, a2, b2, c2
  minimum << 8.0, 1.0, 0.9, 12.0, 4.0, 1.6;
  VectorXd exchanged(6);
  exchanged << 12.0, 4.0, 1.6, 8.0, 1.0, 0.9;
  const std::vector<VectorXd> found = exchanged_minima(model, minimum);
  REQUIRE(found.size() == 1);
  CHECK(found[0] == exchanged);
}

TEST_CASE("curves without interchangeable terms have no exchanged minima") {
  CHECK(exchanged_minima(model_of("y ~ a*(1 - exp(-b*x))"), Eigen::Vector2d(2.0, 0.3)).empty());
  // A sign alone is no exchange: random effects turn with it.
  CHECK(exchanged_minima(model_of("y ~ x^2/(a + b*x)^2"), Eigen::Vector2d(2.0, 0.3)).empty());
}

TEST_CASE("places change with the shares of the terms that they belong to") {
  const char* const formula = "y ~ f/(1 + exp(2*(m - x))) + (1 - f)/(1 + exp(2*(k - x)))";
  // f, m, k in the order of the text; the other way round is the same curve.
  const VectorXd truth = Eigen::Vector3d(0.3, 1.0, 4.0);
  NonlinearModel model = model_of(formula);
  NonlinearModel::Workspace workspace;
  VectorXd mean;
  model.evaluate(truth, mean, nullptr, workspace);
  Table table;
  const VectorXd x = model.column("x");
  table.set("x", std::vector<double>(x.begin(), x.end()));
  table.set("y", std::vector<double>(mean.begin(), mean.end()));
  const NonlinearModel exact(specify_model(formula, {}, table), table);
  const std::vector<VectorXd> same = exchanged_minima(exact, truth);
  REQUIRE(same.size() == 1);
  CHECK(same[0] == VectorXd(Eigen::Vector3d(1.0 - 0.3, 4.0, 1.0)));
  // Residuals near zero are rounding; a slightly wrong curve has some.
  std::vector<double> y(mean.begin(), mean.end());
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += 0.01 * std::sin(3.0 * static_cast<double>(i));
  table.set("y", y);
  const NonlinearModel noisy(specify_model(formula, {}, table), table);
  const std::vector<VectorXd> found = exchanged_locations(noisy, truth);
  REQUIRE(found.size() == 1);
  // Standard errors are about 0.02.
  CHECK((found[0] - Eigen::Vector3d(0.7, 4.0, 1.0)).norm() < 0.2);
}
