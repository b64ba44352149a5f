// SPDX-License-Identifier: MIT
#include "conditional_modes/effect_factor.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;

/// \param designs  number of different ones: 1, or one for each cell
template <class DesignOf>
bool EffectFactor::compute_sparse(const SparsePattern& pattern,
                                  const DesignOf& design_of,
                                  Index designs,
                                  const Eigen::Ref<const MatrixXd>& curvatures,
                                  double ridge) {
  if (!sparse_) sparse_ = std::make_unique<Sparse>();
  bool is_same = sparse_->pattern == &pattern && sparse_->ridge == ridge &&
                 std::ssize(sparse_->joints) == designs &&
                 sparse_->curvatures.cols() == curvatures.cols() &&
                 sparse_->curvatures == curvatures;
  for (Index k = 0; k < designs && is_same; ++k) {
    is_same = sparse_->joints[static_cast<std::size_t>(k)] == design_of(k).joint;
  }
  if (is_same) return sparse_->is_factorized;
  sparse_->pattern = &pattern;
  sparse_->ridge = ridge;
  sparse_->curvatures = curvatures;
  sparse_->joints.clear();
  for (Index k = 0; k < designs; ++k) sparse_->joints.push_back(design_of(k).joint);
  sparse_->is_inverted = false;
  SparseFactor& factor = sparse_->factor;
  factor.begin(pattern, 1.0 + ridge);
  for (Index k = 0; k < curvatures.cols(); ++k) {
    const SmallMatrix& joint = design_of(k).joint;
    const SmallMatrix curvature = unpacked(curvatures.col(k).data(), joint.rows());
    const SmallMatrix curved = curvature.lazyProduct(joint);
    factor.add(k, joint.transpose().lazyProduct(curved));
  }
  return sparse_->is_factorized = factor.factorize();
}

bool EffectFactor::compute(const SparsePattern* pattern,
                           const RandomDesign& design,
                           const Eigen::Ref<const MatrixXd>& curvatures,
                           double ridge) {
  if (pattern == nullptr) return arrow_.compute(design, curvatures, ridge);
  const auto same = [&design](Index) -> const RandomDesign& { return design; };
  return compute_sparse(*pattern, same, 1, curvatures, ridge);
}

bool EffectFactor::compute(const SparsePattern* pattern,
                           std::span<const RandomDesign* const> designs,
                           const Eigen::Ref<const MatrixXd>& curvatures,
                           double ridge) {
  if (pattern == nullptr) return arrow_.compute(designs, curvatures, ridge);
  const auto own = [&designs](Index k) -> const RandomDesign& {
    return *designs[static_cast<std::size_t>(k)];
  };
  return compute_sparse(*pattern, own, std::ssize(designs), curvatures, ridge);
}

void EffectFactor::invert() {
  if (!sparse_ || sparse_->is_inverted) return;
  sparse_->factor.invert();
  sparse_->is_inverted = true;
}

}  // namespace silvafit::fit
