// SPDX-License-Identifier: MIT
#include "model/symmetric_eigen.hpp"

#include <Eigen/Eigenvalues>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {

SymmetricEigen symmetric_eigen(const MatrixXd& matrix) {
  const Index size = matrix.rows();
  if (size == 0) return {};
  if (matrix.allFinite()) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(matrix);
    if (solver.info() == Eigen::Success) return {solver.eigenvalues(), solver.eigenvectors()};
  }
  return {VectorXd::Constant(size, kNaN), MatrixXd::Constant(size, size, kNaN)};
}

namespace {

// Eigenvalues of a correlation matrix below this are rounding.
constexpr double kRounding = 1e-14;

}  // namespace

MatrixXd covariance_factor(const MatrixXd& covariance) {
  if (covariance.size() == 0) return covariance;
  const VectorXd deviations = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VectorXd inverse = (deviations.array() > 0.0).select(deviations.cwiseInverse(), 0.0);
  const MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const SymmetricEigen of = symmetric_eigen(correlation);
  const VectorXd values = (of.values.array() > kRounding).select(of.values, 0.0);
  return deviations.asDiagonal() * of.vectors * values.cwiseSqrt().asDiagonal();
}

MatrixXd symmetric_root(const MatrixXd& covariance) {
  if (covariance.rows() == 0) return covariance;
  const SymmetricEigen of = symmetric_eigen(covariance);
  const VectorXd roots = of.values.cwiseMax(0.0).cwiseSqrt();
  return of.vectors * roots.asDiagonal() * of.vectors.transpose();
}

}  // namespace silvafit::fit
