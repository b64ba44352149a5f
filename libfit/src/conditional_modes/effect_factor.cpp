// SPDX-License-Identifier: MIT
#include "conditional_modes/effect_factor.hpp"

namespace silvafit::fit {

bool EffectFactor::compute(const SparsePattern* pattern,
                           const GroupPriors& priors,
                           const Eigen::Ref<const MatrixXd>& curvatures,
                           Index first,
                           double ridge) {
  if (pattern == nullptr) return arrow_.compute(priors, curvatures, first, ridge);
  if (!sparse_) sparse_ = std::make_unique<Sparse>();
  const SmallMatrix& joint = priors.design(first).joint;
  const bool is_same =
      priors.is_shared() && sparse_->pattern == pattern && sparse_->ridge == ridge &&
      sparse_->joints.size() == 1 && sparse_->joints.front().rows() == joint.rows() &&
      sparse_->joints.front() == joint && sparse_->curvatures.cols() == curvatures.cols() &&
      sparse_->curvatures == curvatures;
  if (is_same) return sparse_->is_factorized;
  sparse_->pattern = pattern;
  sparse_->ridge = ridge;
  sparse_->curvatures = curvatures;
  sparse_->joints.assign(priors.is_shared() ? 1 : 0, joint);
  sparse_->is_inverted = false;
  SparseFactor& factor = sparse_->factor;
  factor.begin(*pattern, 1.0 + ridge);
  for (Index k = 0; k < curvatures.cols(); ++k) {
    const SmallMatrix& of_cell = priors.design(first + k).joint;
    const SmallMatrix curvature = unpacked(curvatures.col(k).data(), of_cell.rows());
    const SmallMatrix curved = curvature.lazyProduct(of_cell);
    factor.add(k, of_cell.transpose().lazyProduct(curved));
  }
  return sparse_->is_factorized = factor.factorize();
}

void EffectFactor::invert() {
  if (!sparse_ || sparse_->is_inverted) return;
  sparse_->factor.invert();
  sparse_->is_inverted = true;
}

}  // namespace silvafit::fit
