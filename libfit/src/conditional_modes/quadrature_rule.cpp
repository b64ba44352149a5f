// SPDX-License-Identifier: MIT
#include "conditional_modes/quadrature_rule.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace silvafit::fit {
namespace {

/// The orthonormal Hermite polynomials of degree 0 to K at x.
VectorXd hermite(int points, double x) {
  VectorXd values(points + 1);
  values[0] = 1.0;
  if (points > 0) values[1] = x;
  for (int k = 1; k < points; ++k) {
    const double degree = k;
    values[k + 1] = (x * values[k] - std::sqrt(degree) * values[k - 1]) / std::sqrt(degree + 1.0);
  }
  return values;
}

/// Eigenvectors give small weights with an absolute error of 1e-16 only, which matters if the
/// integrand is large far from the center. The polynomials give them with a small relative error.
QuadratureRule one_variable(int points) {
  VectorXd off_diagonal(std::max(points - 1, 0));
  for (Index k = 0; k < off_diagonal.size(); ++k) {
    off_diagonal[k] = std::sqrt(static_cast<double>(k + 1));
  }
  Eigen::SelfAdjointEigenSolver<MatrixXd> solver;
  const VectorXd diagonal = VectorXd::Zero(points);
  solver.computeFromTridiagonal(diagonal, off_diagonal, Eigen::EigenvaluesOnly);
  QuadratureRule rule{.nodes = solver.eigenvalues().transpose(), .weights = VectorXd(points)};
  for (Index i = 0; i < points; ++i) {
    double& node = rule.nodes(0, i);
    const VectorXd near = hermite(points, node);
    node -= near[points] / (std::sqrt(static_cast<double>(points)) * near[points - 1]);
    rule.weights[i] = 1.0 / hermite(points, node).head(points).squaredNorm();
  }
  return rule;
}

}  // namespace

QuadratureRule gauss_hermite(int points, Index dimensions) {
  const QuadratureRule line = one_variable(points);
  QuadratureRule rule{.nodes = line.nodes, .weights = line.weights};
  for (Index d = 1; d < dimensions; ++d) {
    const QuadratureRule before = rule;
    const Index count = before.weights.size();
    rule.nodes.resize(d + 1, count * points);
    rule.weights.resize(count * points);
    for (Index k = 0; k < points; ++k) {
      rule.nodes.block(0, k * count, d, count) = before.nodes;
      rule.nodes.row(d).segment(k * count, count).setConstant(line.nodes(0, k));
      rule.weights.segment(k * count, count) = line.weights[k] * before.weights;
    }
  }
  return rule;
}

}  // namespace silvafit::fit
