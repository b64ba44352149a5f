// SPDX-License-Identifier: MIT
#include "conditional_modes/arrow_factor.hpp"

#include <algorithm>
#include <cmath>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

/// Overwrites a symmetric matrix by its lower Cholesky factor, zeros above; false if it has none.
/// The factors of the determinant are multiplied as long as possible, which saves logarithms.
bool factorize(
    double* a, Index n, double& product, double& log_determinant, double& smallest_pivot) {
  for (Index j = 0; j < n; ++j) {
    double pivot = a[j + j * n];
    for (Index k = 0; k < j; ++k) pivot -= a[j + k * n] * a[j + k * n];
    if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
    product *= pivot;
    if (product > 1e150 || product < 1e-150) {
      log_determinant += std::log(product);
      product = 1.0;
    }
    smallest_pivot = std::min(smallest_pivot, pivot);
    const double root = std::sqrt(pivot);
    a[j + j * n] = root;
    for (Index i = j + 1; i < n; ++i) {
      double value = a[i + j * n];
      for (Index k = 0; k < j; ++k) value -= a[i + k * n] * a[j + k * n];
      a[i + j * n] = value / root;
      a[j + i * n] = 0.0;
    }
  }
  return true;
}

/// Solves L L' x = b in place.
void solve_factorized(const double* l, Index n, double* x) {
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < i; ++k) x[i] -= l[i + k * n] * x[k];
    x[i] /= l[i + i * n];
  }
  for (Index i = n - 1; i >= 0; --i) {
    for (Index k = i + 1; k < n; ++k) x[i] -= l[k + i * n] * x[k];
    x[i] /= l[i + i * n];
  }
}

}  // namespace

SmallMatrix unpacked(const double* triangle, Index size) {
  SmallMatrix result(size, size);
  for (Index column = 0; column < size; ++column) {
    for (Index row = column; row < size; ++row) {
      result(row, column) = result(column, row) = *triangle++;
    }
  }
  return result;
}

void ArrowFactor::resize(Index s, Index q, Index m) {
  s_ = s;
  q_ = q;
  m_ = m;
  memory_.resize(static_cast<std::size_t>(m * (q * q + 2 * s * q) + s * s));
}

bool ArrowFactor::compute(const GroupPriors& priors,
                          const Eigen::Ref<const MatrixXd>& curvatures,
                          Index first,
                          double ridge) {
  resize(priors.design(first).shared, priors.design(first).own(), curvatures.cols());
  product_ = 1.0;
  log_determinant_ = 0.0;
  smallest_pivot_ = kInfinity;
  Map complement(group(m_), s_, s_);
  complement.setZero();
  complement.diagonal().setConstant(1.0 + ridge);
  for (Index k = 0; k < m_; ++k) {
    const RandomDesign& design = priors.design(first + k);
    const SmallMatrix curvature = unpacked(curvatures.col(k).data(), design.joint.rows());
    const auto own = design.joint.rightCols(q_);
    const SmallMatrix curved = curvature.lazyProduct(own);
    Map block(group(k), q_, q_);
    block = own.transpose().lazyProduct(curved);
    block.diagonal().array() += 1.0 + ridge;
    if (!factorize(group(k), q_, product_, log_determinant_, smallest_pivot_)) return false;
    if (s_ == 0) continue;
    Map coupling(group(k) + q_ * q_, s_, q_);
    Map solved(group(k) + q_ * q_ + s_ * q_, q_, s_);
    const auto shared = design.joint.leftCols(s_);
    coupling = shared.transpose().lazyProduct(curved);
    solved = coupling.transpose();
    for (Index j = 0; j < s_; ++j) solve_factorized(group(k), q_, solved.col(j).data());
    const SmallMatrix curved_shared = curvature.lazyProduct(shared);
    complement += shared.transpose().lazyProduct(curved_shared);
    complement -= coupling.lazyProduct(solved);
  }
  return factorize(group(m_), s_, product_, log_determinant_, smallest_pivot_);
}

void ArrowFactor::solve(Eigen::Ref<VectorXd> z) const {
  auto u = z.head(s_);
  Map v(z.data() + s_, q_, m_);
  for (Index k = 0; k < m_ && s_ > 0; ++k) {
    const ConstMap solved(group(k) + q_ * q_ + s_ * q_, q_, s_);
    u -= solved.transpose().lazyProduct(v.col(k));
  }
  solve_factorized(group(m_), s_, u.data());
  for (Index k = 0; k < m_; ++k) {
    solve_factorized(group(k), q_, v.col(k).data());
    if (s_ == 0) continue;
    const ConstMap solved(group(k) + q_ * q_ + s_ * q_, q_, s_);
    v.col(k) -= solved.lazyProduct(u);
  }
}

SmallMatrix ArrowFactor::inverse_block(Index k) const {
  SmallMatrix inverse = SmallMatrix::Identity(s_ + q_, s_ + q_);
  SmallMatrix own = SmallMatrix::Identity(q_, q_);
  for (Index j = 0; j < q_; ++j) solve_factorized(group(k), q_, own.col(j).data());
  inverse.bottomRightCorner(q_, q_) = own;
  if (s_ == 0) return inverse;
  const ConstMap solved(group(k) + q_ * q_ + s_ * q_, q_, s_);
  SmallMatrix shared = SmallMatrix::Identity(s_, s_);
  for (Index j = 0; j < s_; ++j) solve_factorized(group(m_), s_, shared.col(j).data());
  const SmallMatrix cross = solved.lazyProduct(shared);
  inverse.topLeftCorner(s_, s_) = shared;
  inverse.bottomLeftCorner(q_, s_) = -cross;
  inverse.topRightCorner(s_, q_) = -cross.transpose();
  inverse.bottomRightCorner(q_, q_) += cross.lazyProduct(solved.transpose());
  return inverse;
}

double ArrowFactor::log_determinant() const { return log_determinant_ + std::log(product_); }

}  // namespace silvafit::fit
