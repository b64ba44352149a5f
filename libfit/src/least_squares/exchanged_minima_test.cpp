// SPDX-License-Identifier: MIT
#include "least_squares/exchanged_minima.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>
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

TEST_CASE("coefficients adapt to exchanged rates") {
  // Theory of the one-compartment model: the volume V becomes V ke/ka.
  const NonlinearModel model =
      model_of("y ~ exp(ka - v)*(exp(-exp(ke)*x) - exp(-exp(ka)*x))/(exp(ka) - exp(ke))");
  const VectorXd point = Eigen::Vector3d(0.4, 3.1, -2.0);  // ka, v, ke
  const std::vector<VectorXd> found = points_of_same_mean(model, point);
  REQUIRE(!found.empty());
  const VectorXd other = Eigen::Vector3d(-2.0, 3.1 - 2.0 - 0.4, 0.4);
  for (const VectorXd& reached : found) CHECK((reached - other).norm() < 1e-6);
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

TEST_CASE("an exchange changes nothing if the random effects are not on the exchanged terms") {
  Table table;
  std::vector<double> x;
  std::vector<double> y;
  silvafit::data::TextColumn group;
  for (int i = 0; i < 12; ++i) {
    x.push_back(0.2 + 0.5 * i);
    y.push_back(1.0 / (1.0 + i));
    group.append(i % 2 == 0 ? "g" : "h");
  }
  table.set("g", group);
  table.set("x", x);
  table.set("y", y);
  const char* const formula = "y ~ c + A*exp(-k*x) + B*exp(-l*x)";
  const auto exchanged = [&](const char* random) {
    ModelSpecification specification = specify_model(formula, {}, table);
    add_random_effects(specification, random, table);
    VectorXd minimum(5);  // c, A, k, B, l
    minimum << 0.3, 2.8, 0.8, 0.5, 0.2;
    return exchanged_minima(NonlinearModel(specification, table), minimum);
  };
  CHECK(exchanged("c | g").empty());
  CHECK(exchanged("A | g").size() == 1);
  CHECK(exchanged("A + B | g").size() == 1);
}

TEST_CASE("phases are shifted if their period has random effects") {
  Table table;
  std::vector<double> x;
  std::vector<double> y;
  silvafit::data::TextColumn group;
  for (int i = 0; i <= 20; ++i) {
    x.push_back(i);
    y.push_back(1.0 / (1.0 + i));
    group.append(i % 2 == 0 ? "g" : "h");
  }
  table.set("g", group);
  table.set("x", x);
  table.set("y", y);
  const auto exchanged = [&](const char* random) {
    ModelSpecification specification = specify_model("y ~ M + A*cos(2*pi*(x - t)/P)", {}, table);
    add_random_effects(specification, random, table);
    const VectorXd minimum = Eigen::Vector4d(10.0, 2.0, 7.0, 8.0);  // M, A, t, P
    return exchanged_minima(NonlinearModel(specification, table), minimum);
  };
  CHECK(exchanged("t | g").empty());
  // Half periods of 4 from 0 to 20: t = 3, 11, 15, 19, of which 3, 11 and 19 turn the wave. With
  // the sign of P also changed, the cosine is the same.
  std::vector<std::pair<double, double>> found;
  for (const VectorXd& point : exchanged("P | g")) {
    if (point[3] > 0.0) found.emplace_back(point[2], point[1]);
  }
  std::ranges::sort(found);
  const std::vector<std::pair<double, double>> expected{
      {3.0, -2.0}, {11.0, -2.0}, {15.0, 2.0}, {19.0, -2.0}};
  CHECK(found == expected);
}

TEST_CASE("a phase moves as near to another one as half periods allow") {
  const NonlinearModel model = model_of("y ~ M + A*cos(2*pi*(x - t)/P)");
  const VectorXd at = Eigen::Vector4d(10.0, 2.0, 7.0, 8.0);  // M, A, t, P
  const auto nearest = [&](double t) {
    return with_nearest_phases(model, at, Eigen::Vector4d(10.0, 2.0, t, 8.0));
  };
  CHECK(nearest(24.0) == VectorXd(Eigen::Vector4d(10.0, 2.0, 23.0, 8.0)));
  CHECK(nearest(-1.5) == VectorXd(Eigen::Vector4d(10.0, 2.0, -1.0, 8.0)));
  CHECK(nearest(11.5) == VectorXd(Eigen::Vector4d(10.0, -2.0, 11.0, 8.0)));
  CHECK(nearest(8.0) == at);
  // Without another coefficient that turns the wave, shifts are by whole periods.
  const NonlinearModel given = model_of("y ~ exp(cos(2*pi*(x - t)/8))");
  CHECK(with_nearest_phases(given, VectorXd::Constant(1, 7.0), VectorXd::Constant(1, 11.5))[0] ==
        15.0);
}

TEST_CASE("half a period turns the sign of an amplitude") {
  const NonlinearModel model = model_of("y ~ M + A*cos(2*pi*(x - t)/8)");
  const VectorXd at = Eigen::Vector3d(10.0, -2.0, 1.0);
  const VectorXd turned = with_signs_of(model, at, Eigen::Vector3d(9.0, 3.0, 0.0));
  CHECK(turned == VectorXd(Eigen::Vector3d(10.0, 2.0, 5.0)));
  CHECK(with_signs_of(model, at, Eigen::Vector3d(9.0, -3.0, 0.0)) == at);
}

TEST_CASE("a phase many periods away moves to the observations") {
  // x is from 0.2 to 5.7, the argument zero at an observation for t from 0.2 to 5.7.
  const NonlinearModel model = model_of("y ~ M + A*cos(2*pi*(x - t)/8)");
  const auto phase_from = [](const NonlinearModel& of, double phase) {
    return with_usual_phases(of, Eigen::Vector3d(10.0, 2.0, phase))[2];
  };
  CHECK(phase_from(model, 3.0) == 3.0);
  CHECK(phase_from(model, 3.0 + 8.0 * 5) == Approx(3.0).epsilon(1e-14));
  // The digits of 8e7 are 1.5e-8.
  CHECK(phase_from(model, 3.0 - 8.0e7) == Approx(3.0).margin(2e-8));
  // The user may count periods from elsewhere.
  CHECK(phase_from(model, 11.0) == 11.0);
  const NonlinearModel outside = model_of("y ~ M + A*cos(2*pi*(x - t)/8) + 0.1*t");
  CHECK(phase_from(outside, 83.0) == 83.0);
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

TEST_CASE("of exchanged minima the one nearest to a start is chosen in all units") {
  const NonlinearModel model = model_of("y ~ A*exp(-k*x) + B*exp(-l*x)");
  const VectorXd minimum = Eigen::Vector4d(2.8, 0.8, 0.5, 0.2);  // A, k, B, l
  const VectorXd exchanged = Eigen::Vector4d(0.5, 0.2, 2.8, 0.8);
  const VectorXd start = Eigen::Vector4d(1.0, 1.0, 1.0, 2.0);
  CHECK(nearest_minimum(model, minimum, start) == exchanged);
  CHECK(nearest_minimum(model, exchanged, start) == exchanged);
  const VectorXd units = Eigen::Vector4d(1000.0, 1e-3, 1000.0, 1e-3);
  CHECK(nearest_minimum(model, minimum.cwiseProduct(units), start.cwiseProduct(units)) ==
        exchanged.cwiseProduct(units));
  CHECK(nearest_minimum(model, minimum, VectorXd(minimum.array() * 1.3)) == minimum);
}
