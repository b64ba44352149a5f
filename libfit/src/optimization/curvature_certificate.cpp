// SPDX-License-Identifier: MIT
#include "optimization/curvature_certificate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

// Smaller eigenvalues of the scaled Hessian are rounding errors, even if it is symmetric.
constexpr double kSmallestCurvature = 1e-9;
// Variables with a relatively smaller curvature than the largest one have none.
constexpr double kSmallestDiagonal = 1e-6;
// A smaller gradient along a direction without curvature counts as zero: a step of a hundred
// standard deviations would gain a thousandth.
constexpr double kNoSlope = 1e-5;

/// One over the square root of the diagonal; directions without curvature keep their unit.
VectorXd units(const MatrixXd& hessian) {
  const VectorXd diagonal = hessian.diagonal().cwiseAbs();
  const double floor = std::max(kSmallestDiagonal * diagonal.maxCoeff(), 1e-300);
  return diagonal.unaryExpr([floor](double d) { return 1.0 / std::sqrt(std::max(d, floor)); });
}

}  // namespace

CurvatureCertificate::CurvatureCertificate(const MatrixXd& hessian, const VectorXd& gradient) {
  const VectorXd unit = units(hessian);
  const MatrixXd scaled = unit.asDiagonal() * hessian * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (scaled + scaled.transpose()));
  if (!scaled.allFinite() || solver.info() != Eigen::Success) {
    decrement_ = kInfinity;
    return;
  }
  const double doubt =
      std::max(kSmallestCurvature, 4.0 * (scaled - scaled.transpose()).cwiseAbs().maxCoeff());
  const VectorXd slopes = solver.eigenvectors().transpose() * unit.cwiseProduct(gradient);
  for (Index k = 0; k < slopes.size(); ++k) {
    const double curvature = solver.eigenvalues()[k];
    if (curvature <= doubt && std::abs(slopes[k]) < kNoSlope) continue;
    decrement_ += slopes[k] * slopes[k] / std::max(curvature, doubt);
  }
  if (solver.eigenvalues()[0] < -doubt) {
    downwards_ = unit.cwiseProduct(solver.eigenvectors().col(0));
  }
}

MatrixXd informed_inverse(const MatrixXd& hessian) {
  const VectorXd unit = units(hessian);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(unit.asDiagonal() * hessian *
                                                       unit.asDiagonal());
  if (!hessian.allFinite() || solver.info() != Eigen::Success) {
    return MatrixXd::Constant(hessian.rows(), hessian.cols(), kNaN);
  }
  VectorXd inverse = solver.eigenvalues();
  for (double& value : inverse) value = value > kSmallestCurvature ? 1.0 / value : 0.0;
  return unit.asDiagonal() * solver.eigenvectors() * inverse.asDiagonal() *
         solver.eigenvectors().transpose() * unit.asDiagonal();
}

bool is_of_minimum(const MatrixXd& hessian) {
  if (!hessian.allFinite()) return false;
  const VectorXd unit = units(hessian);
  const MatrixXd scaled = unit.asDiagonal() * hessian * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scaled, Eigen::EigenvaluesOnly);
  return solver.info() == Eigen::Success && solver.eigenvalues()[0] > -kSmallestCurvature;
}

InformedCovariance informed_covariance(const MatrixXd& hessian, const MatrixXd& transform) {
  const VectorXd unit = units(hessian);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(unit.asDiagonal() * hessian *
                                                       unit.asDiagonal());
  const Index rows = transform.rows();
  if (!hessian.allFinite() || solver.info() != Eigen::Success) {
    return {MatrixXd::Constant(rows, rows, kNaN), rows};
  }
  MatrixXd roots = transform * unit.asDiagonal() * solver.eigenvectors();
  // Rounding errors turn the directions by less.
  constexpr double kSmallestPart = 1e-2;
  const VectorXd least = kSmallestPart * roots.rowwise().norm();
  InformedCovariance result;
  std::vector<Index> unknown;
  for (Index k = 0; k < roots.cols(); ++k) {
    const double curvature = solver.eigenvalues()[k];
    const bool is_informed = curvature > kSmallestCurvature;
    const std::size_t known = unknown.size();
    for (Index j = 0; j < rows && !is_informed; ++j) {
      if (std::abs(roots(j, k)) > least[j]) unknown.push_back(j);
    }
    if (unknown.size() > known) ++result.unknown_directions;
    roots.col(k) *= is_informed ? 1.0 / std::sqrt(curvature) : 0.0;
  }
  for (const Index j : unknown) roots.row(j).setConstant(kNaN);
  result.covariance = roots * roots.transpose();
  return result;
}

}  // namespace silvafit::fit
