// SPDX-License-Identifier: MIT
#include "optimization/quasi_newton.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <thread>
#include <utility>
#include <vector>

#include "optimization/fixed_point.hpp"

using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace silvafit::fit;

namespace {

// Rosenbrock's valley, whose minimum is 0 at (1, 1).
double valley(const VectorXd& x, VectorXd* gradient) {
  const double across = x[1] - x[0] * x[0];
  if (gradient != nullptr) {
    *gradient = Eigen::Vector2d(-400.0 * x[0] * across - 2.0 * (1.0 - x[0]), 200.0 * across);
  }
  return 100.0 * across * across + (1.0 - x[0]) * (1.0 - x[0]);
}

}  // namespace

TEST_CASE("the minimum of Rosenbrock's function is found") {
  const QuasiNewtonResult result = minimize(valley, Eigen::Vector2d(-1.2, 1.0));
  CHECK((result.x - Eigen::Vector2d(1.0, 1.0)).norm() < 1e-6);
  CHECK(result.decrement <= 1e-14);
  const MatrixXd hessian =
      hessian_from_gradients(valley, Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(0.0, 0.0));
  // Second derivatives of the function at its minimum, by hand.
  CHECK(hessian(0, 0) == Approx(802.0).epsilon(1e-6));
  CHECK(hessian(0, 1) == Approx(-400.0).epsilon(1e-6));
  CHECK(hessian(1, 1) == Approx(200.0).epsilon(1e-6));
}

TEST_CASE("the Hessian does not depend on how curved the coordinates are") {
  // A bowl of the curvature 2 in bent coordinates: at 0, where it is lowest, bending changes
  // nothing.
  constexpr double kBend = 5000.0;
  const SmoothFunction bent = [](const VectorXd& x, VectorXd* gradient) {
    const double across = x[1] - kBend * x[0] * x[0];
    if (gradient != nullptr)
      *gradient = Eigen::Vector2d(2.0 * x[0] - 4.0 * kBend * x[0] * across, 2.0 * across);
    return x[0] * x[0] + across * across;
  };
  const VectorXd bottom = VectorXd::Zero(2);
  const MatrixXd one_sided = one_sided_hessian(bent, bottom, bottom);
  CHECK(one_sided(1, 0) == Approx(-0.1).epsilon(1e-6));  // -2 kBend times the step of 1e-5
  const MatrixXd hessian = hessian_from_gradients(bent, bottom, bottom);
  CHECK((hessian - 2.0 * MatrixXd::Identity(2, 2)).cwiseAbs().maxCoeff() < 1e-5);
}

TEST_CASE("curvature within a standard error counts the jumps of a slope") {
  // 50 x^2, of which only a tenth is curvature between the steps of the slope.
  constexpr double kStep = 1e-3;
  const SmoothFunction jagged = [](const VectorXd& x, VectorXd* gradient) {
    const double step = kStep * std::round(x[0] / kStep);
    const double slope = 10.0 * x[0] + 90.0 * step;
    if (gradient != nullptr) *gradient = VectorXd::Constant(1, slope);
    return 50.0 * x[0] * x[0];
  };
  const VectorXd bottom = VectorXd::Zero(1);
  CHECK(hessian_from_gradients(jagged, bottom, bottom)(0, 0) == Approx(10.0).epsilon(1e-6));
  CHECK(hessian_over_errors(jagged, bottom, bottom)(0, 0) == Approx(100.0).epsilon(0.01));
}

// The first of them sets the level of the warnings of Ceres.
TEST_CASE("several threads search at once") {
  std::vector<QuasiNewtonResult> results(4);
  {
    std::vector<std::jthread> threads;
    threads.reserve(results.size());
    for (QuasiNewtonResult& result : results) {
      threads.emplace_back([&] { result = minimize(valley, Eigen::Vector2d(-1.2, 1.0)); });
    }
  }
  for (const QuasiNewtonResult& result : results) {
    CHECK((result.x - Eigen::Vector2d(1.0, 1.0)).norm() < 1e-6);
  }
}

TEST_CASE("a search leaves a saddle point and stays in the domain") {
  const SmoothFunction saddle = [](const VectorXd& x, VectorXd* gradient) {
    if (std::abs(x[0]) > 5.0) return std::numeric_limits<double>::infinity();
    if (gradient != nullptr) {
      *gradient = VectorXd::Constant(1, 4.0 * x[0] * (x[0] * x[0] - 4.0));
    }
    return std::pow(x[0] * x[0] - 4.0, 2);
  };
  const QuasiNewtonResult result = minimize(saddle, VectorXd::Constant(1, 0.1));
  CHECK(std::abs(result.x[0]) == Approx(2.0).epsilon(1e-7));
}

TEST_CASE("mixing ends a two-cycle and speeds a slow iteration") {
  // x -> A x + b with eigenvalues -1 (a cycle) and 0.98 (slow); fixed point (I - A)^-1 b.
  const Eigen::Vector2d diagonal(-1.0, 0.98);
  const Eigen::Vector2d shift(2.0, 0.02);
  AndersonMixing mixing(4);
  VectorXd x = Eigen::Vector2d(5.0, -3.0);
  for (int step = 0; step < 6; ++step) {
    const VectorXd image = diagonal.cwiseProduct(x) + shift;
    x = mixing.next(x, image);
  }
  CHECK((x - Eigen::Vector2d(1.0, 1.0)).norm() < 1e-9);
}

TEST_CASE("a search can end at once if the descent is below rounding errors") {
  // Digits after the tenth are noise.
  int evaluations = 0;
  const SmoothFunction noisy = [&](const VectorXd& x, VectorXd* gradient) {
    const double noise = 1e-10 * std::sin(1e9 * x.sum() + ++evaluations);
    if (gradient != nullptr) *gradient = (2.0 * x).array() + 1e3 * noise;
    return x.squaredNorm() + noise;
  };
  const VectorXd start = Eigen::Vector3d(1.0, -0.5, 0.3);
  minimize(noisy, start, {}, {.decrement = 1e-20, .rounded_decrement = 0.0});
  const int without = std::exchange(evaluations, 0);
  const QuasiNewtonResult found =
      minimize(noisy, start, {}, {.decrement = 1e-20, .rounded_decrement = 1e-10});
  CHECK(found.x.norm() < 1e-4);
  CHECK(evaluations < without / 2);
}

TEST_CASE("consecutive short steps at a discontinuity can end a search") {
  // Beyond x0 = 0.9 the function is larger by a hundred; it decreases towards this discontinuity.
  const SmoothFunction cliff = [](const VectorXd& x, VectorXd* gradient) {
    if (gradient != nullptr) *gradient = Eigen::Vector2d(-1.0, 2.0 * x[1]);
    return -x[0] + x[1] * x[1] + (x[0] > 0.9 ? 100.0 : 0.0);
  };
  const QuasiNewtonResult found =
      minimize(cliff, Eigen::Vector2d(0.0, 1.0), {}, {.most_short_steps = 3});
  CHECK(found.is_blocked);
  CHECK(found.x[0] <= 0.9);
  CHECK_FALSE(minimize(cliff, Eigen::Vector2d(0.0, 1.0)).is_blocked);
}

TEST_CASE("at the end of the domain the Hessian uses the other side") {
  // The gradient outside is unchanged, as in the likelihoods.
  double lowest = 0.0;
  const SmoothFunction bowl = [&](const VectorXd& x, VectorXd* gradient) {
    if (x[1] > 1.0 || x[1] < lowest) return std::numeric_limits<double>::infinity();
    if (gradient != nullptr) *gradient = Eigen::Vector2d(6.0 * x[0], 4.0 * x[1]);
    return 3.0 * x[0] * x[0] + 2.0 * x[1] * x[1];
  };
  const VectorXd edge = Eigen::Vector2d(0.5, 1.0);
  const VectorXd slope = Eigen::Vector2d(3.0, 4.0);
  for (const MatrixXd& hessian :
       {hessian_from_gradients(bowl, edge, slope), one_sided_hessian(bowl, edge, slope)}) {
    CHECK(hessian(0, 0) == Approx(6.0).epsilon(1e-9));
    CHECK(hessian(1, 1) == Approx(4.0).epsilon(1e-9));
    CHECK(hessian(0, 1) == 0.0);
  }
  // A search from the end of the domain still finds the minimum.
  CHECK(minimize(bowl, edge).x.norm() < 1e-6);
  lowest = 1.0;  // the domain is a single line
  for (const MatrixXd& hessian :
       {hessian_from_gradients(bowl, edge, slope), one_sided_hessian(bowl, edge, slope)}) {
    CHECK(hessian(0, 0) == Approx(6.0).epsilon(1e-9));
    CHECK(std::isnan(hessian(1, 1)));
  }
}
