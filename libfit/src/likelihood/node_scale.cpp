// SPDX-License-Identifier: MIT
#include "likelihood/node_scale.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "model/symmetric_eigen.hpp"

namespace silvafit::fit {
namespace {

constexpr double kUsual = 0.5;    // from this eigenvalue on, f is the identity
constexpr double kLowest = 0.25;  // its limit

struct RaisedEigenvalue {
  double value = 0.0;
  double slope = 1.0;
};

/// f and f'. With w the distance below kUsual in units of kUsual - kLowest, f - kLowest is
/// (kUsual - kLowest) / (1 + w + w^2) = (kUsual - kLowest) (1 - w + O(w^3)).
RaisedEigenvalue raised(double eigenvalue) {
  if (eigenvalue >= kUsual) return {.value = eigenvalue};
  constexpr double kRange = kUsual - kLowest;
  const double w = (kUsual - eigenvalue) / kRange;
  const double denominator = 1.0 + w + w * w;
  return {.value = kLowest + kRange / denominator,
          .slope = (1.0 + 2.0 * w) / (denominator * denominator)};
}

/// The derivative by a matrix from that by its Cholesky factor.
/// Source: Murray 2016, Differentiation of the Cholesky decomposition, arXiv:1602.07527.
SmallMatrix by_cholesky(const SmallMatrix& lower, const SmallMatrix& by_lower) {
  SmallMatrix inside = lower.transpose() * by_lower;
  inside = inside.triangularView<Eigen::Lower>().toDenseMatrix().eval();
  inside.diagonal() *= 0.5;
  SmallMatrix result = inside + inside.transpose();
  lower.transpose().triangularView<Eigen::Upper>().solveInPlace(result);
  result.transposeInPlace();
  lower.transpose().triangularView<Eigen::Upper>().solveInPlace(result);
  return 0.5 * result;
}

}  // namespace

NodeScale::NodeScale(const SmallMatrix& hessian) {
  const SymmetricEigen of = symmetric_eigen(hessian);
  const Index size = hessian.rows();
  if (of.values.minCoeff() >= kUsual) {
    lower_ = hessian.llt().matrixL();
    return;
  }
  vectors_ = of.vectors;
  slopes_.resize(size, size);
  SmallMatrix values = SmallMatrix::Zero(size, size);
  for (Index i = 0; i < size; ++i) {
    const RaisedEigenvalue at_i = raised(of.values[i]);
    values(i, i) = at_i.value;
    for (Index j = 0; j < size; ++j) {
      // Divided differences of close eigenvalues lose their digits.
      constexpr double kClose = 1e-5;
      const double distance = of.values[i] - of.values[j];
      slopes_(i, j) = std::abs(distance) > kClose
                          ? (at_i.value - raised(of.values[j]).value) / distance
                          : raised(0.5 * (of.values[i] + of.values[j])).slope;
    }
  }
  const SmallMatrix scale = vectors_ * values * vectors_.transpose();
  lower_ = scale.llt().matrixL();
}

double NodeScale::log_determinant() const { return 2.0 * lower_.diagonal().array().log().sum(); }

/// Source of the derivative of a function of a matrix: Daleckii and Krein; Bhatia 1997, Matrix
/// Analysis, section V.3.
SmallMatrix NodeScale::by_hessian(const SmallMatrix& by_lower) const {
  const SmallMatrix by_scale = by_cholesky(lower_, by_lower);
  if (slopes_.size() == 0) return by_scale;
  const SmallMatrix inside = vectors_.transpose() * by_scale * vectors_;
  return vectors_ * inside.cwiseProduct(slopes_) * vectors_.transpose();
}

}  // namespace silvafit::fit
