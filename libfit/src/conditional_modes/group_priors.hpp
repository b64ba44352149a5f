// SPDX-License-Identifier: MIT
// The distribution of the random effects of groups before their data are used.
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "conditional_modes/effect_factor.hpp"

namespace silvafit::fit {

/// The effects b of group g are offset_g + design_g z_g with independent standard normal effects
/// z_g of all terms. The designs and offsets must outlive this object.
class GroupPriors {
 public:
  /// The distribution of the model: the same design for all groups, without an offset.
  explicit GroupPriors(const RandomDesign& design) : shared_(&design) {}
  /// \param designs  (G) all with the same number of effects
  /// \param offsets  (r x G)
  GroupPriors(std::vector<const RandomDesign*> designs, const Eigen::MatrixXd& offsets)
      : designs_(std::move(designs)), offsets_(&offsets) {}

  const RandomDesign& design(Eigen::Index group) const {
    return shared_ != nullptr ? *shared_ : *designs_[static_cast<std::size_t>(group)];
  }
  /// Null where all are zero.
  const Eigen::MatrixXd* offsets() const { return offsets_; }

  /// Factorizes the Hessian of a cluster with groups [first, first + number of curvatures).
  /// \param pattern  of crossed groups, or null
  bool factorize(const SparsePattern* pattern,
                 Eigen::Index first,
                 const Eigen::Ref<const Eigen::MatrixXd>& curvatures,
                 double ridge,
                 EffectFactor& factor) const {
    if (shared_ != nullptr) return factor.compute(pattern, *shared_, curvatures, ridge);
    const std::span<const RandomDesign* const> all(designs_);
    const auto count = static_cast<std::size_t>(curvatures.cols());
    return factor.compute(
        pattern, all.subspan(static_cast<std::size_t>(first), count), curvatures, ridge);
  }

 private:
  const RandomDesign* shared_ = nullptr;
  std::vector<const RandomDesign*> designs_;
  const Eigen::MatrixXd* offsets_ = nullptr;
};

}  // namespace silvafit::fit
