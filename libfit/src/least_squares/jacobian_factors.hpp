// SPDX-License-Identifier: MIT
// The Jacobian of the mean as orthogonal and triangular factors, and coefficients not identifiable.
#pragma once

#include <Eigen/QR>
#include <vector>

#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// (p + 1 x p + 1) the triangle R of the QR decomposition of the columns of J, divided by their
/// lengths, and of r. Blocks of rows are added to the triangle of those before them, so that it
/// needs little memory.
/// \param jacobian   (N x p), finite
/// \param lengths    (p), positive
/// \param residuals  (N) r, or empty for zeros
MatrixXd triangle_of(const MatrixXd& jacobian, const VectorXd& lengths, const VectorXd& residuals);

/// J = Q R with pivoting, in coefficients of equal column length. Q is not kept: J may have as many
/// rows as there is memory for.
class JacobianFactors {
 public:
  // Smallest diagonal element of R with columns of equal length. Below it, a column is a sum of the
  // others, except for rounding or nearly.
  static constexpr double kRankTolerance = 1e-11;
  static constexpr double kNearTolerance = 1e-7;

  /// \param jacobian   (N x p), finite; p may be 0
  /// \param residuals  (N) r, or empty
  explicit JacobianFactors(const MatrixXd& jacobian,
                           double tolerance = kRankTolerance,
                           const VectorXd& residuals = {});

  Index rank() const { return rank_; }

  /// (rank) Q' r
  const VectorXd& projected() const { return projected_; }

  /// (p x k) changes of the coefficients for (rank x k) changes in u.
  MatrixXd to_coefficients(const MatrixXd& u) const;

  /// Coefficients with a component in a direction that does not change the mean.
  std::vector<Index> confounded() const;

 private:
  MatrixXd triangle() const { return qr_.matrixQR().topLeftCorner(rank(), rank()); }

  VectorXd scale_;
  VectorXd projected_;
  Index rank_ = 0;
  Eigen::ColPivHouseholderQR<MatrixXd> qr_;  ///< of the triangle that blocks of rows leave
};

}  // namespace silvafit::fit
