// SPDX-License-Identifier: MIT
#include "arrow_factor.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;

double log_determinant_of(const Eigen::LLT<SmallMatrix>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

bool is_positive(const Eigen::LLT<SmallMatrix>& factor) {
  return factor.info() == Eigen::Success && factor.matrixLLT().allFinite();
}

}  // namespace

bool ArrowFactor::compute(const RandomDesign& design,
                          std::span<const SmallMatrix> curvatures,
                          double ridge) {
  const Index s = design.outer.cols();
  const Index q = design.inner.cols();
  has_outer_ = s > 0;
  count_ = curvatures.size();
  if (groups_.size() < count_) groups_.resize(count_);
  SmallMatrix complement = SmallMatrix::Identity(s, s) * (1.0 + ridge);
  for (std::size_t k = 0; k < count_; ++k) {
    Group& group = groups_[k];
    const SmallMatrix curved = curvatures[k] * design.inner;
    SmallMatrix block = design.inner.transpose() * curved;
    block.diagonal().array() += 1.0 + ridge;
    if (q > 0) {
      group.factor.compute(block);
      if (!is_positive(group.factor)) return false;
    }
    if (!has_outer_) continue;
    group.coupling = design.outer.transpose() * curved;
    group.solved = group.coupling.transpose();
    if (q > 0) group.factor.solveInPlace(group.solved);
    complement += design.outer.transpose() * curvatures[k] * design.outer;
    complement -= group.coupling * group.solved;
  }
  if (!has_outer_) return true;
  complement_.compute(complement);
  return is_positive(complement_);
}

double ArrowFactor::log_determinant() const {
  double sum = has_outer_ ? log_determinant_of(complement_) : 0.0;
  for (std::size_t k = 0; k < count_; ++k) sum += log_determinant_of(groups_[k].factor);
  return sum;
}

void ArrowFactor::solve(SmallVector& u, std::span<SmallVector> v) const {
  if (has_outer_) {
    for (std::size_t k = 0; k < count_; ++k) u -= groups_[k].solved.transpose() * v[k];
    complement_.solveInPlace(u);
  }
  for (std::size_t k = 0; k < count_; ++k) {
    groups_[k].factor.solveInPlace(v[k]);
    if (has_outer_) v[k] -= groups_[k].solved * u;
  }
}

SmallMatrix ArrowFactor::inverse_block(std::size_t k) const {
  const Group& group = groups_[k];
  const Index q = group.factor.rows();
  const Index s = has_outer_ ? complement_.rows() : 0;
  SmallMatrix inverse(s + q, s + q);
  SmallMatrix own = SmallMatrix::Identity(q, q);
  group.factor.solveInPlace(own);
  inverse.bottomRightCorner(q, q) = own;
  if (!has_outer_) return inverse;
  SmallMatrix outer = SmallMatrix::Identity(s, s);
  complement_.solveInPlace(outer);
  inverse.topLeftCorner(s, s) = outer;
  inverse.bottomLeftCorner(q, s) = -group.solved * outer;
  inverse.topRightCorner(s, q) = inverse.bottomLeftCorner(q, s).transpose();
  inverse.bottomRightCorner(q, q) += group.solved * outer * group.solved.transpose();
  return inverse;
}

}  // namespace silvafit::fit
