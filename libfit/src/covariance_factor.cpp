// SPDX-License-Identifier: MIT
#include "covariance_factor.hpp"

#include <Eigen/Eigenvalues>

namespace silvafit::fit {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

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
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(correlation);
  result.vectors = solver.eigenvectors();
  const VectorXd& values = solver.eigenvalues();
  result.values = (values.array() > kRounding).select(values, 0.0);
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
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(covariance);
  const VectorXd roots = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return solver.eigenvectors() * roots.asDiagonal() * solver.eigenvectors().transpose();
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
