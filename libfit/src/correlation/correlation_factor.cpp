// SPDX-License-Identifier: MIT
#include "correlation/correlation_factor.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

// Rows that are closer to linear dependence than this have no digits left.
constexpr double kSingular = 1e-13;

/// x_i = phi_i x_(i-1) + sd_i u_i: the inverse of L has two diagonals.
class MarkovFactor : public CorrelationFactor {
 public:
  MarkovFactor(VectorXd before, MatrixXd slopes)
      : before_(std::move(before)), slopes_(std::move(slopes)) {
    before_[0] = 0.0;
    slopes_.row(0).setZero();
    const VectorXd variance = (1.0 - before_.array()) * (1.0 + before_.array());
    is_valid = variance.minCoeff() > kSingular;
    deviation_ = variance.cwiseMax(kSingular).cwiseSqrt();
    log_determinant_ = deviation_.array().log().sum();
    log_slopes_ = -slopes_.transpose() * before_.cwiseQuotient(deviation_.cwiseAbs2());
  }

  void whiten(Ref<MatrixXd> columns) const override {
    for (Index i = columns.rows() - 1; i > 0; --i) {
      columns.row(i) = (columns.row(i) - before_[i] * columns.row(i - 1)) / deviation_[i];
    }
  }

  void whiten_transposed(Ref<MatrixXd> columns) const override {
    const Index n = columns.rows();
    for (Index i = 0; i < n; ++i) {
      columns.row(i) /= deviation_[i];
      if (i + 1 < n) columns.row(i) -= before_[i + 1] / deviation_[i + 1] * columns.row(i + 1);
    }
  }

  void color(Ref<MatrixXd> columns) const override {
    for (Index i = 1; i < columns.rows(); ++i) {
      columns.row(i) = deviation_[i] * columns.row(i) + before_[i] * columns.row(i - 1);
    }
  }

  MatrixXd slope(Index k, const MatrixXd& whitened) const override {
    MatrixXd original = whitened;
    color(original);
    MatrixXd result = MatrixXd::Zero(whitened.rows(), whitened.cols());
    for (Index i = 1; i < whitened.rows(); ++i) {
      const double by = slopes_(i, k) / deviation_[i];
      result.row(i) = by * (before_[i] / deviation_[i] * whitened.row(i) - original.row(i - 1));
    }
    return result;
  }

  // Q has three diagonals, and rows of sum one: Q X is X + D'HD X with differences D of neighbors.
  MatrixXd times_expected(const MatrixXd& columns) const override {
    MatrixXd result = columns;
    for (Index i = 1; i < columns.rows(); ++i) {
      const double share = before_[i] / deviation_[i];
      const Eigen::RowVectorXd change = share * share * (columns.row(i) - columns.row(i - 1));
      result.row(i) += change;
      result.row(i - 1) -= change;
    }
    return result;
  }

  double expected_slope(Index k, const MatrixXd& x, const MatrixXd& y) const override {
    double result = 0.0;
    for (Index i = 1; i < x.rows(); ++i) {
      const double variance = deviation_[i] * deviation_[i];
      result += 2.0 * before_[i] * slopes_(i, k) / (variance * variance) *
                (x.row(i) - x.row(i - 1)).dot(y.row(i) - y.row(i - 1));
    }
    return result;
  }

  bool is_valid = false;

 private:
  VectorXd before_;
  MatrixXd slopes_;
  VectorXd deviation_;  ///< (n) of the row given the one before
};

class DenseFactor : public CorrelationFactor {
 public:
  DenseFactor(const MatrixXd& correlation, std::vector<MatrixXd> slopes)
      : factor_(correlation), slopes_(std::move(slopes)) {
    const VectorXd diagonal = factor_.matrixLLT().diagonal();
    is_valid = factor_.info() == Eigen::Success && diagonal.minCoeff() > std::sqrt(kSingular);
    if (!is_valid) return;
    log_determinant_ = diagonal.array().log().sum();
    log_slopes_.resize(std::ssize(slopes_));
    for (std::size_t k = 0; k < slopes_.size(); ++k) {
      MatrixXd& of = slopes_[k];
      factor_.matrixL().solveInPlace(of);
      of.transposeInPlace();
      factor_.matrixL().solveInPlace(of);
      log_slopes_[static_cast<Index>(k)] = 0.5 * of.trace();
    }
  }

  void whiten(Ref<MatrixXd> columns) const override { factor_.matrixL().solveInPlace(columns); }
  void whiten_transposed(Ref<MatrixXd> columns) const override {
    factor_.matrixU().solveInPlace(columns);
  }
  void color(Ref<MatrixXd> columns) const override {
    columns = (factor_.matrixL() * MatrixXd(columns)).eval();
  }
  MatrixXd slope(Index k, const MatrixXd& whitened) const override {
    return -0.5 * slopes_[static_cast<std::size_t>(k)] * whitened;
  }
  MatrixXd times_expected(const MatrixXd& columns) const override {
    // Only some likelihoods need it, many times.
    if (expected_.size() == 0) {
      expected_ = inverse().cwiseProduct(factor_.reconstructedMatrix());
    }
    return expected_ * columns;
  }
  double expected_slope(Index k, const MatrixXd& x, const MatrixXd& y) const override {
    const MatrixXd& slope = slopes_[static_cast<std::size_t>(k)];
    const MatrixXd lower = factor_.matrixL();
    MatrixXd by_inverse = slope;
    whiten_transposed(by_inverse);
    by_inverse.transposeInPlace();
    whiten_transposed(by_inverse);
    const MatrixXd by_correlation = lower * slope * lower.transpose();
    const MatrixXd change = inverse().cwiseProduct(by_correlation) -
                            by_inverse.cwiseProduct(factor_.reconstructedMatrix());
    return (x.transpose() * change * y).trace();
  }

  bool is_valid = false;

 private:
  MatrixXd inverse() const {
    return factor_.solve(MatrixXd::Identity(factor_.rows(), factor_.cols()));
  }

  Eigen::LLT<MatrixXd> factor_;
  std::vector<MatrixXd> slopes_;  ///< L^-1 dR L^-1'
  mutable MatrixXd expected_;     ///< Q, once it was used
};

}  // namespace

std::unique_ptr<CorrelationFactor> markov_factor(VectorXd before, MatrixXd slopes) {
  auto factor = std::make_unique<MarkovFactor>(std::move(before), std::move(slopes));
  if (!factor->is_valid) return nullptr;
  return factor;
}

std::unique_ptr<CorrelationFactor> dense_factor(const MatrixXd& correlation,
                                                std::vector<MatrixXd> slopes) {
  auto factor = std::make_unique<DenseFactor>(correlation, std::move(slopes));
  if (!factor->is_valid) return nullptr;
  return factor;
}

}  // namespace silvafit::fit
