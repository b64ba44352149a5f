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

/// Standard deviations, eigenvectors and eigenvalues of the correlation matrix.
struct Decomposition {
  VectorXd deviations{};
  MatrixXd vectors{};
  VectorXd values{};
};

Decomposition decomposed(const MatrixXd& covariance) {
  Decomposition result{.deviations = covariance.diagonal().cwiseMax(0.0).cwiseSqrt()};
  const VectorXd inverse =
      (result.deviations.array() > 0.0).select(result.deviations.cwiseInverse(), 0.0);
  const MatrixXd correlation = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const SymmetricEigen eigen = symmetric_eigen(correlation);
  result.vectors = eigen.vectors;
  result.values = (eigen.values.array() > kRounding).select(eigen.values, 0.0);
  return result;
}

}  // namespace

MatrixXd covariance_factor(const MatrixXd& covariance) {
  if (covariance.size() == 0) return covariance;
  const Decomposition of = decomposed(covariance);
  return of.deviations.asDiagonal() * of.vectors * of.values.cwiseSqrt().asDiagonal();
}

MatrixXd symmetric_root(const MatrixXd& covariance) {
  if (covariance.rows() == 0) return covariance;
  const SymmetricEigen of = symmetric_eigen(covariance);
  const VectorXd roots = of.values.cwiseMax(0.0).cwiseSqrt();
  return of.vectors * roots.asDiagonal() * of.vectors.transpose();
}

MatrixXd regression_on(const MatrixXd& cross, const MatrixXd& covariance) {
  if (covariance.size() == 0) return cross;
  const Decomposition of = decomposed(covariance);
  const VectorXd inverse = (of.deviations.array() > 0.0).select(of.deviations.cwiseInverse(), 0.0);
  const VectorXd values = (of.values.array() > 0.0).select(of.values.cwiseInverse(), 0.0);
  return cross * inverse.asDiagonal() * of.vectors * values.asDiagonal() * of.vectors.transpose() *
         inverse.asDiagonal();
}

}  // namespace silvafit::fit
