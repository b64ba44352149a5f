// SPDX-License-Identifier: MIT
// Derivatives of the modes of the random effects by the parameters of a marginal likelihood.
#include "likelihood/marginal_block.hpp"

namespace silvafit::fit {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

void MarginalBlock::keep(const RandomDesign& design) {
  kept_design_ = design;
  kept_outer_ = modes_.outer();
  kept_inner_ = modes_.inner();
  kept_density_ = modes_.density();
  kept_totals_ = totals_;
}

SmallVector MarginalBlock::slope_change(const PointChange& change,
                                        const SmallMatrix& curvature,
                                        Index cluster,
                                        Index group) const {
  const VectorXd& beta = change.observation.beta;
  const auto others = static_cast<Index>(sums_.others().size());
  const Index m = change.observation.variance.size() + 1;
  SmallVector shift = change.design.inner.lazyProduct(kept_inner_.col(group));
  if (kept_outer_.rows() > 0) shift += change.design.outer.lazyProduct(kept_outer_.col(cluster));
  if (others < beta.size()) {
    for (Index c = 0; c < r_; ++c) shift[c] += beta[sums_.random()[static_cast<std::size_t>(c)]];
  }
  SmallVector result = curvature.lazyProduct(shift);
  const auto mixed = kept_totals_.col(group).tail((others + m) * r_);
  for (Index o = 0; o < others; ++o) {
    const double moved = beta[sums_.others()[static_cast<std::size_t>(o)]];
    result += moved * mixed.segment(o * r_, r_);
  }
  for (Index e = 0; e < m; ++e) {
    const double moved = e + 1 < m ? change.observation.variance[e] : change.observation.log_sigma;
    result += moved * mixed.segment((others + e) * r_, r_);
  }
  return result;
}

void MarginalBlock::follow(const PointChange& change, Modes& modes) {
  // At a mode the gradient of the objective is zero: the mode moves by -H^-1 times the change of
  // the gradient by the parameters.
  constexpr double kFar = 1.0;  // squared standard deviation
  VectorXd outer(kept_outer_.rows());
  MatrixXd inner;
  MatrixXd inner_right;
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    const Index begin = modes_.group_begin(c);
    const Index groups = modes_.group_count(c);
    const auto curvatures = kept_density_.block(1 + r_, begin, r_ * (r_ + 1) / 2, groups);
    if (!kept_hessian_.compute(kept_design_, curvatures)) continue;
    outer.setZero();
    inner.resize(kept_inner_.rows(), groups);
    for (Index k = 0; k < groups; ++k) {
      const SmallMatrix curvature = unpacked(curvatures.col(k).data(), r_);
      const SmallVector turn = slope_change(change, curvature, c, begin + k);
      const auto slope = kept_density_.col(begin + k).segment(1, r_);
      inner.col(k) = -kept_design_.inner.transpose().lazyProduct(turn);
      inner.col(k) -= change.design.inner.transpose().lazyProduct(slope);
      if (outer.size() == 0) continue;
      outer -= kept_design_.outer.transpose().lazyProduct(turn);
      outer -= change.design.outer.transpose().lazyProduct(slope);
    }
    const VectorXd outer_right = outer;
    inner_right = inner;
    kept_hessian_.solve(outer, inner);
    const double distance = outer_right.dot(outer) + inner_right.cwiseProduct(inner).sum();
    if (!(distance < kFar)) continue;
    if (outer.size() > 0) modes.outer.col(modes_.first_cluster() + c) += outer;
    modes.inner.middleCols(modes_.first_group() + begin, groups) += inner;
  }
}

}  // namespace silvafit::fit
