// SPDX-License-Identifier: MIT
#include "relative_factor.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <utility>

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

RelativeFactor::RelativeFactor(Covariance form, VectorXd scales)
    : form_(form), scales_(std::move(scales)) {
  if (scales_.size() == 0) return;
  identity_ = scales_.cwiseInverse();
  identity_ /= std::exp(identity_.array().log().mean());
}

Index RelativeFactor::parameter_count() const {
  switch (form_) {
    case Covariance::kGeneral:
      return size() * (size() + 1) / 2;
    case Covariance::kDiagonal:
      return size();
    case Covariance::kIdentity:
      return size() > 0 ? 1 : 0;
  }
  return 0;
}

MatrixXd RelativeFactor::factor(const VectorXd& parameters) const {
  MatrixXd result = MatrixXd::Zero(size(), size());
  if (size() == 0) return result;
  if (form_ == Covariance::kIdentity) {
    result.diagonal() = parameters[0] * identity_;
  } else if (form_ == Covariance::kDiagonal) {
    result.diagonal() = parameters;
  } else {
    for (Index column = 0, k = 0; column < size(); ++column) {
      for (Index row = column; row < size(); ++row) result(row, column) = parameters[k++];
    }
  }
  return result;
}

VectorXd RelativeFactor::from_diagonal(const VectorXd& diagonal) const {
  const MatrixXd squared = diagonal.cwiseAbs2().asDiagonal();
  return from_covariance(squared);
}

VectorXd RelativeFactor::from_covariance(const MatrixXd& relative_covariance) const {
  VectorXd parameters(parameter_count());
  if (size() == 0) return parameters;
  if (form_ == Covariance::kIdentity) {
    parameters[0] = (relative_covariance.diagonal().cwiseSqrt().array() / identity_.array()).mean();
  } else if (form_ == Covariance::kDiagonal) {
    parameters = relative_covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  } else {
    // A triangular factor of a matrix that may be singular: the R of a QR of its symmetric square
    // root.
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(relative_covariance);
    const MatrixXd root = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
                          solver.eigenvectors().transpose();
    MatrixXd upper = Eigen::HouseholderQR<MatrixXd>(root).matrixQR().triangularView<Eigen::Upper>();
    for (Index row = 0; row < size(); ++row) {
      if (upper(row, row) < 0.0) upper.row(row) *= -1.0;
    }
    for (Index column = 0, k = 0; column < size(); ++column) {
      for (Index row = column; row < size(); ++row) parameters[k++] = upper(column, row);
    }
  }
  return parameters;
}

VectorXd RelativeFactor::from_factor(const MatrixXd& factor) const {
  if (form_ != Covariance::kIdentity) return gradient(factor);
  VectorXd result(parameter_count());
  if (size() > 0) result[0] = factor.diagonal().dot(identity_) / identity_.squaredNorm();
  return result;
}

VectorXd RelativeFactor::gradient(const MatrixXd& by_factor) const {
  VectorXd result(parameter_count());
  if (size() == 0) return result;
  if (form_ == Covariance::kIdentity) {
    result[0] = by_factor.diagonal().dot(identity_);
  } else if (form_ == Covariance::kDiagonal) {
    result = by_factor.diagonal();
  } else {
    for (Index column = 0, k = 0; column < size(); ++column) {
      for (Index row = column; row < size(); ++row) result[k++] = by_factor(row, column);
    }
  }
  return result;
}

}  // namespace silvafit::fit
