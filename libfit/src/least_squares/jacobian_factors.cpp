// SPDX-License-Identifier: MIT
#include "least_squares/jacobian_factors.hpp"

#include <algorithm>

namespace silvafit::fit {

MatrixXd triangle_of(const MatrixXd& jacobian, const VectorXd& lengths, const VectorXd& residuals) {
  constexpr Index kRows = 512;
  const Index p = jacobian.cols();
  MatrixXd triangle = MatrixXd::Zero(p + 1, p + 1);
  MatrixXd stacked;
  Eigen::HouseholderQR<MatrixXd> qr;
  for (Index begin = 0; begin < jacobian.rows(); begin += kRows) {
    const Index rows = std::min(kRows, jacobian.rows() - begin);
    stacked.setZero(p + 1 + rows, p + 1);
    stacked.topRows(p + 1) = triangle;
    stacked.bottomLeftCorner(rows, p) =
        jacobian.middleRows(begin, rows) * lengths.cwiseInverse().asDiagonal();
    if (residuals.size() > 0) {
      stacked.bottomRightCorner(rows, 1) = residuals.segment(begin, rows);
    }
    qr.compute(stacked);
    triangle = qr.matrixQR().topRows(p + 1).triangularView<Eigen::Upper>();
  }
  return triangle;
}

JacobianFactors::JacobianFactors(const MatrixXd& jacobian,
                                 double tolerance,
                                 const VectorXd& residuals)
    : scale_(jacobian.colwise().stableNorm()) {
  scale_ = (scale_.array() > 0.0).select(scale_, 1.0);
  const Index p = jacobian.cols();
  const MatrixXd triangle = triangle_of(jacobian, scale_, residuals);
  // All coefficients may be held; Eigen does not decompose a matrix without columns.
  if (p == 0) return;
  qr_.setThreshold(tolerance);
  qr_.compute(triangle.topLeftCorner(p, p));
  rank_ = qr_.rank();
  projected_ = (qr_.householderQ().adjoint() * triangle.col(p).head(p)).head(rank());
}

MatrixXd JacobianFactors::to_coefficients(const MatrixXd& u) const {
  MatrixXd result = MatrixXd::Zero(scale_.size(), u.cols());
  if (rank() == 0) return result;
  result.topRows(rank()) = triangle().triangularView<Eigen::Upper>().solve(u);
  result = qr_.colsPermutation() * result;
  return scale_.cwiseInverse().asDiagonal() * result;
}

std::vector<Index> JacobianFactors::confounded() const {
  std::vector<Index> result;
  const Index p = scale_.size();
  if (rank() == p) return result;
  MatrixXd directions = MatrixXd::Zero(p, p - rank());
  directions.topRows(rank()) = -triangle().triangularView<Eigen::Upper>().solve(
      qr_.matrixQR().topRightCorner(rank(), p - rank()));
  directions.bottomRows(p - rank()).setIdentity();
  directions = qr_.colsPermutation() * directions;
  for (Index i = 0; i < p; ++i) {
    if (directions.row(i).cwiseAbs().maxCoeff() > 1e-6) result.push_back(i);
  }
  return result;
}

}  // namespace silvafit::fit
