// SPDX-License-Identifier: MIT
#include "marginal_likelihood/quadrature_rule.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

QuadratureRule one_variable(int points) {
  VectorXd off_diagonal(std::max(points - 1, 0));
  for (Index k = 0; k < off_diagonal.size(); ++k) {
    off_diagonal[k] = std::sqrt(static_cast<double>(k + 1));
  }
  Eigen::SelfAdjointEigenSolver<MatrixXd> solver;
  const VectorXd diagonal = VectorXd::Zero(points);
  solver.computeFromTridiagonal(diagonal, off_diagonal);
  return {.nodes = solver.eigenvalues().transpose(),
          .weights = solver.eigenvectors().row(0).cwiseAbs2().transpose()};
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
