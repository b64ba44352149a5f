// SPDX-License-Identifier: MIT
// The Jacobian of the mean as orthogonal and triangular factors, and coefficients not identifiable.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>
#include <vector>

namespace silvafit::fit {

/// J = Q R with pivoting, in coefficients of equal column length.
class JacobianFactors {
 public:
  // Smallest diagonal element of R with columns of equal length. Below it, a column is a sum of the
  // others, except for rounding or nearly.
  static constexpr double kRankTolerance = 1e-11;
  static constexpr double kNearTolerance = 1e-7;

  /// \param jacobian  (N x p), finite
  explicit JacobianFactors(const Eigen::MatrixXd& jacobian, double tolerance = kRankTolerance)
      : scale_(jacobian.colwise().stableNorm()) {
    scale_ = (scale_.array() > 0.0).select(scale_, 1.0);
    qr_.setThreshold(tolerance);
    qr_.compute(jacobian * scale_.cwiseInverse().asDiagonal());
  }

  Eigen::Index rank() const { return qr_.rank(); }

  /// (rank) Q' r
  Eigen::VectorXd project(const Eigen::VectorXd& residuals) const {
    return (qr_.householderQ().adjoint() * residuals).head(rank());
  }

  /// (p x k) changes of the coefficients for (rank x k) changes in u.
  Eigen::MatrixXd to_coefficients(const Eigen::MatrixXd& u) const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(scale_.size(), u.cols());
    result.topRows(rank()) = triangle().triangularView<Eigen::Upper>().solve(u);
    result = qr_.colsPermutation() * result;
    return scale_.cwiseInverse().asDiagonal() * result;
  }

  /// Coefficients with a component in a direction that does not change the mean.
  std::vector<Eigen::Index> confounded() const {
    std::vector<Eigen::Index> result;
    const Eigen::Index p = scale_.size();
    if (rank() == p) return result;
    Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(p, p - rank());
    directions.topRows(rank()) = -triangle().triangularView<Eigen::Upper>().solve(
        qr_.matrixQR().topRightCorner(rank(), p - rank()));
    directions.bottomRows(p - rank()).setIdentity();
    directions = qr_.colsPermutation() * directions;
    for (Eigen::Index i = 0; i < p; ++i) {
      if (directions.row(i).cwiseAbs().maxCoeff() > 1e-6) result.push_back(i);
    }
    return result;
  }

 private:
  Eigen::MatrixXd triangle() const { return qr_.matrixQR().topLeftCorner(rank(), rank()); }

  Eigen::VectorXd scale_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

}  // namespace silvafit::fit
