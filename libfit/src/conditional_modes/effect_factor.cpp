// SPDX-License-Identifier: MIT
#include "conditional_modes/effect_factor.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;

/// \param is_shared  whether all cells have the same design
template <class DesignOf>
bool EffectFactor::compute_sparse(const SparsePattern& pattern,
                                  const DesignOf& design_of,
                                  bool is_shared,
                                  const Eigen::Ref<const MatrixXd>& curvatures,
                                  double ridge) {
  if (!sparse_) sparse_ = std::make_unique<Sparse>();
  const SmallMatrix& first = design_of(0).joint;
  const bool is_same =
      is_shared && sparse_->pattern == &pattern && sparse_->ridge == ridge &&
      sparse_->joints.size() == 1 && sparse_->joints.front().rows() == first.rows() &&
      sparse_->joints.front() == first && sparse_->curvatures.cols() == curvatures.cols() &&
      sparse_->curvatures == curvatures;
  if (is_same) return sparse_->is_factorized;
  sparse_->pattern = &pattern;
  sparse_->ridge = ridge;
  sparse_->curvatures = curvatures;
  sparse_->joints.assign(is_shared ? 1 : 0, first);
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
  return compute_sparse(*pattern, same, true, curvatures, ridge);
}

bool EffectFactor::compute(const SparsePattern* pattern,
                           std::span<const RandomDesign* const> designs,
                           const Eigen::Ref<const MatrixXd>& curvatures,
                           double ridge) {
  if (pattern == nullptr) return arrow_.compute(designs, curvatures, ridge);
  const auto own = [&designs](Index k) -> const RandomDesign& {
    return *designs[static_cast<std::size_t>(k)];
  };
  return compute_sparse(*pattern, own, false, curvatures, ridge);
}

void EffectFactor::invert() {
  if (!sparse_ || sparse_->is_inverted) return;
  sparse_->factor.invert();
  sparse_->is_inverted = true;
}

}  // namespace silvafit::fit
