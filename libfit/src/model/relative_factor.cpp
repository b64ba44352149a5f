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

/// The Cholesky factor of alpha^2 I + (beta^2 - alpha^2)/q 11', with rows of equal elements left of
/// the diagonal, and its derivative along a change of (alpha, beta). It is smooth at zeros.
struct SymmetricFactor {
  MatrixXd value;
  MatrixXd change;

  SymmetricFactor(Index q, double alpha, double beta, double by_alpha, double by_beta)
      : value(MatrixXd::Zero(q, q)), change(value) {
    const auto size = static_cast<double>(q);
    const double common = (beta * beta - alpha * alpha) / size;
    const double by_common = 2.0 * (beta * by_beta - alpha * by_alpha) / size;
    // Roots of alpha^2 + j common, the determinants' ratios.
    double before = alpha;
    double by_before = by_alpha;
    for (Index j = 0; j < q; ++j) {
      // The last one is beta, without cancellation.
      const bool is_last = j + 1 == q;
      const auto count = static_cast<double>(j + 1);
      const double root = is_last ? beta : std::sqrt(std::max(0.0, alpha * alpha + count * common));
      const double by_root =
          is_last ? by_beta
                  : (root > 0.0 ? (alpha * by_alpha + 0.5 * count * by_common) / root : 0.0);
      // alpha / before is 1 for the first column, also at 0.
      const double share = j == 0 || before == 0.0 ? 1.0 : alpha / before;
      const double by_share =
          j == 0 || before == 0.0 ? 0.0 : (by_alpha - share * by_before) / before;
      value(j, j) = share * root;
      change(j, j) = by_share * root + share * by_root;
      if (is_last) break;
      const double below = root > 0.0 ? share * common / root : 0.0;
      const double by_below =
          root > 0.0 ? (by_share * common + share * by_common - below * by_root) / root : 0.0;
      value.col(j).tail(q - j - 1).setConstant(below);
      change.col(j).tail(q - j - 1).setConstant(by_below);
      before = root;
      by_before = by_root;
    }
  }
};

}  // namespace

RelativeFactor::RelativeFactor(const RandomEffects& random, VectorXd scales)
    : is_identity_(scales.size() > 0 &&
                   (random.covariance == Covariance::kIdentity ||
                    (random.covariance == Covariance::kCompoundSymmetry && scales.size() == 1))),
      is_symmetric_(scales.size() > 1 && random.covariance == Covariance::kCompoundSymmetry),
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
  if (is_symmetric_) return 2;
  return is_identity_ ? 1 : static_cast<Index>(elements_.size());
}

MatrixXd RelativeFactor::factor(const VectorXd& parameters) const {
  MatrixXd result = MatrixXd::Zero(size(), size());
  if (is_identity_) {
    result.diagonal() = parameters[0] * identity_;
    return result;
  }
  if (is_symmetric_) {
    const SymmetricFactor own(size(), parameters[0], parameters[1], 0.0, 0.0);
    return identity_.asDiagonal() * own.value;
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
  if (is_symmetric_) {
    const VectorXd units = identity_.cwiseInverse();
    const MatrixXd own = units.asDiagonal() * relative_covariance * units.asDiagonal();
    const auto q = static_cast<double>(size());
    const double common = own.sum() / q;
    const double other = (own.trace() - common) / (q - 1.0);
    return Eigen::Vector2d(std::sqrt(std::max(0.0, other)), std::sqrt(std::max(0.0, common)));
  }
  MatrixXd result = MatrixXd::Zero(size(), size());
  Index begin = 0;
  for (const int width : blocks_) {
    result.block(begin, begin, width, width) =
        semidefinite_factor(relative_covariance.block(begin, begin, width, width));
    begin += width;
  }
  return free_elements(result);
}

VectorXd RelativeFactor::from_factor(const MatrixXd& factor) const {
  if (is_symmetric_) {
    // The second diagonal element has the sign of alpha, the last one that of alpha beta.
    VectorXd result = from_covariance(factor * factor.transpose());
    const Index last = size() - 1;
    if (last > 1 && factor(1, 1) < 0.0) result[0] = -result[0];
    if (factor(last, last) * (last > 1 ? factor(1, 1) : 1.0) < 0.0) result[1] = -result[1];
    return result;
  }
  if (!is_identity_) return free_elements(factor);
  return VectorXd::Constant(1, factor.diagonal().dot(identity_) / identity_.squaredNorm());
}

VectorXd RelativeFactor::gradient(const VectorXd& parameters, const MatrixXd& by_factor) const {
  if (is_identity_) return VectorXd::Constant(1, by_factor.diagonal().dot(identity_));
  if (!is_symmetric_) return free_elements(by_factor);
  const MatrixXd lower = by_factor.triangularView<Eigen::Lower>();
  const MatrixXd by_own = identity_.asDiagonal() * lower;
  const auto along = [&](double by_alpha, double by_beta) {
    const SymmetricFactor own(size(), parameters[0], parameters[1], by_alpha, by_beta);
    return own.change.cwiseProduct(by_own).sum();
  };
  return Eigen::Vector2d(along(1.0, 0.0), along(0.0, 1.0));
}

VectorXd RelativeFactor::free_elements(const MatrixXd& by_factor) const {
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
