// SPDX-License-Identifier: MIT
#include "likelihood/node_scale.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "conditional_modes/quadrature_rule.hpp"

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace silvafit::fit;

namespace {

/// A symmetric matrix with given eigenvalues.
SmallMatrix with_eigenvalues(const VectorXd& values) {
  MatrixXd mixed(3, 3);
  mixed << 1.0, 0.4, -0.3, 0.2, 1.0, 0.7, -0.5, 0.1, 1.0;
  const MatrixXd q = mixed.householderQr().householderQ();
  return q * values.asDiagonal() * q.transpose();
}

/// log of the integral of exp(-n (y - v^2)^2 / 2 - v^2 / 2), whose second derivative at the mode
/// v = 0 is -curvature.
struct FlatDensity {
  double observations = 1.0;
  double curvature = 0.0;

  double log_density(double v) const {
    const double y = (1.0 - curvature) / (2.0 * observations);
    return -0.5 * observations * std::pow(y - v * v, 2) - 0.5 * v * v;
  }
  double exact() const {
    constexpr int kIntervals = 20000;
    constexpr double kReach = 12.0;
    double sum = 0.0;
    for (int k = 0; k <= kIntervals; ++k) {
      sum += std::exp(log_density(-kReach + 2.0 * kReach * k / kIntervals));
    }
    return std::log(sum * 2.0 * kReach / kIntervals);
  }
  double by_quadrature(int points) const {
    const NodeScale scale(SmallMatrix::Constant(1, 1, curvature));
    const QuadratureRule rule = gauss_hermite(points, 1);
    double sum = 0.0;
    for (Index k = 0; k < points; ++k) {
      const double x = rule.nodes(0, k);
      sum += rule.weights[k] * std::exp(0.5 * x * x + log_density(x / scale.lower()(0, 0)));
    }
    return std::log(sum) + 0.5 * std::log(2.0 * std::numbers::pi) - 0.5 * scale.log_determinant();
  }
};

}  // namespace

TEST_CASE("nodes have the scale of the Hessian where it is far from flat") {
  const SmallMatrix hessian = with_eigenvalues(Eigen::Vector3d(0.6, 3.0, 200.0));
  const NodeScale scale(hessian);
  CHECK((scale.lower() * scale.lower().transpose()).isApprox(hessian, 1e-13));
  CHECK(scale.log_determinant() == Approx(std::log(360.0)).epsilon(1e-12));
}

TEST_CASE("the scale of nodes is bounded where the Hessian is flat or bent") {
  const double smallest = GENERATE(0.3, 0.01, 0.0, -2.0, -1e3);
  const NodeScale scale(with_eigenvalues(Eigen::Vector3d(smallest, 0.4, 5.0)));
  const MatrixXd raised = scale.lower() * scale.lower().transpose();
  const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(raised).eigenvalues();
  CHECK(values[0] >= 0.25 - 1e-12);
  CHECK(values[0] >= smallest);
  CHECK(values[1] < 0.5);
  CHECK(values[2] == Approx(5.0).epsilon(1e-12));
}

TEST_CASE("the derivative by the Hessian equals differences") {
  const double smallest = GENERATE(0.7, 0.45, 0.1, -0.5);
  const SmallMatrix hessian = with_eigenvalues(Eigen::Vector3d(smallest, 0.48, 2.0));
  SmallMatrix weights(3, 3);
  weights << 1.0, 0.0, 0.0, -0.7, 0.4, 0.0, 0.2, 1.5, -0.3;
  const auto value = [&](const SmallMatrix& at) {
    return weights.cwiseProduct(NodeScale(at).lower()).sum();
  };
  const SmallMatrix derivative = NodeScale(hessian).by_hessian(weights);
  for (Index i = 0; i < 3; ++i) {
    for (Index j = 0; j < 3; ++j) {
      constexpr double kStep = 1e-6;
      SmallMatrix above = hessian;
      SmallMatrix below = hessian;
      above(i, j) += 0.5 * kStep;
      above(j, i) += 0.5 * kStep;
      below(i, j) -= 0.5 * kStep;
      below(j, i) -= 0.5 * kStep;
      const double difference = (value(above) - value(below)) / (2.0 * kStep);
      // Differences of a step of 1e-6 have about nine digits, the divided differences of f seven.
      CHECK(0.5 * (derivative(i, j) + derivative(j, i)) == Approx(difference).margin(1e-7));
    }
  }
}

TEST_CASE("quadrature converges to the integral of a density with a flat mode") {
  const double curvature = GENERATE(0.3, 0.05, 0.0, -0.5);
  const FlatDensity density{.observations = 3.0, .curvature = curvature};
  INFO("curvature " << curvature);
  // The density falls as exp(-1.5 v^4), faster than any normal one, so that convergence is slow: a
  // digit for ten times the nodes. With the scale of the Hessian itself there is none at zero.
  CHECK(density.by_quadrature(7) == Approx(density.exact()).margin(0.5));
  CHECK(density.by_quadrature(40) == Approx(density.exact()).margin(0.1));
  CHECK(density.by_quadrature(100) == Approx(density.exact()).margin(5e-3));
}
