// SPDX-License-Identifier: MIT
#include "model/relative_factor.hpp"

#include <Eigen/QR>
#include <cmath>
#include <utility>

#include "model/symmetric_eigen.hpp"

namespace silvafit::fit {

namespace {

/// A triangular factor of a matrix that may be singular: the R of a QR of its symmetric square
/// root.
MatrixXd semidefinite_factor(const MatrixXd& covariance) {
  const SymmetricEigen of = symmetric_eigen(covariance);
  const MatrixXd root = of.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * of.vectors.transpose();
  MatrixXd upper = Eigen::HouseholderQR<MatrixXd>(root).matrixQR().triangularView<Eigen::Upper>();
  for (Index row = 0; row < upper.rows(); ++row) {
    if (upper(row, row) < 0.0) upper.row(row) *= -1.0;
  }
  return upper.transpose();
}

}  // namespace

RelativeFactor::RelativeFactor(const RandomEffects& random, VectorXd scales)
    : is_identity_(random.covariance == Covariance::kIdentity && scales.size() > 0),
      scales_(std::move(scales)),
      blocks_(random.block_sizes()) {
  Index begin = 0;
  for (const int size : blocks_) {
    for (Index column = begin; column < begin + size; ++column) {
      for (Index row = column; row < begin + size; ++row) elements_.emplace_back(row, column);
    }
    begin += size;
  }
  if (scales_.size() == 0) return;
  identity_ = scales_.cwiseInverse();
  identity_ /= std::exp(identity_.array().log().mean());
}

Index RelativeFactor::parameter_count() const {
  return is_identity_ ? 1 : static_cast<Index>(elements_.size());
}

MatrixXd RelativeFactor::factor(const VectorXd& parameters) const {
  MatrixXd result = MatrixXd::Zero(size(), size());
  if (is_identity_) {
    result.diagonal() = parameters[0] * identity_;
    return result;
  }
  Index k = 0;
  for (const auto& [row, column] : elements_) result(row, column) = parameters[k++];
  return result;
}

VectorXd RelativeFactor::from_diagonal(const VectorXd& diagonal) const {
  const MatrixXd squared = diagonal.cwiseAbs2().asDiagonal();
  return from_covariance(squared);
}

VectorXd RelativeFactor::from_covariance(const MatrixXd& relative_covariance) const {
  if (is_identity_) {
    const VectorXd deviations = relative_covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    return VectorXd::Constant(1, (deviations.array() / identity_.array()).mean());
  }
  MatrixXd result = MatrixXd::Zero(size(), size());
  Index begin = 0;
  for (const int width : blocks_) {
    result.block(begin, begin, width, width) =
        semidefinite_factor(relative_covariance.block(begin, begin, width, width));
    begin += width;
  }
  return gradient(result);
}

VectorXd RelativeFactor::from_factor(const MatrixXd& factor) const {
  if (!is_identity_) return gradient(factor);
  return VectorXd::Constant(1, factor.diagonal().dot(identity_) / identity_.squaredNorm());
}

VectorXd RelativeFactor::gradient(const MatrixXd& by_factor) const {
  if (is_identity_) return VectorXd::Constant(1, by_factor.diagonal().dot(identity_));
  VectorXd result(parameter_count());
  Index k = 0;
  for (const auto& [row, column] : elements_) result[k++] = by_factor(row, column);
  return result;
}

MatrixXd spherical_effects(const MatrixXd& factor, const MatrixXd& effects) {
  if (factor.size() == 0) return effects;
  // Directions of L that are smaller by this factor contain no significant random effects.
  constexpr double kSmallestPivot = 1e-6;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
  solver.setThreshold(kSmallestPivot);
  solver.compute(factor);
  return solver.solve(effects);
}

}  // namespace silvafit::fit
