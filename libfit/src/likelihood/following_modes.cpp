// SPDX-License-Identifier: MIT
// Derivatives of the modes of the random effects by the parameters of a marginal likelihood.
#include "likelihood/marginal_block.hpp"

namespace silvafit::fit {

void MarginalBlock::keep(const RandomDesign& design) {
  kept_design_ = design;
  kept_modes_ = modes_.modes();
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
  const SmallVector mode = modes_.of_group(
      modes_.of_cluster(kept_modes_, cluster), cluster, group - modes_.group_begin(cluster));
  SmallVector shift = change.design.joint.lazyProduct(mode);
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

void MarginalBlock::follow(const PointChange& change, VectorXd& modes) {
  // At a mode the gradient of the objective is zero: the mode moves by -H^-1 times the change of
  // the gradient by the parameters.
  constexpr double kFar = 1.0;  // squared standard deviation
  VectorXd step;
  for (Index c = 0; c < modes_.cluster_count(); ++c) {
    const Index begin = modes_.group_begin(c);
    const Index groups = modes_.group_count(c);
    const auto curvatures = kept_density_.block(1 + r_, begin, r_ * (r_ + 1) / 2, groups);
    if (!kept_hessian_.compute(modes_.pattern(c), kept_design_, curvatures)) continue;
    step.setZero(modes_.size_of(c));
    for (Index k = 0; k < groups; ++k) {
      const SmallMatrix curvature = unpacked(curvatures.col(k).data(), r_);
      const SmallVector turn = slope_change(change, curvature, c, begin + k);
      const auto slope = kept_density_.col(begin + k).segment(1, r_);
      SmallVector own = -kept_design_.joint.transpose().lazyProduct(turn);
      own -= change.design.joint.transpose().lazyProduct(slope);
      modes_.add_to_group(step, c, k, own);
    }
    const VectorXd right = step;
    kept_hessian_.solve(step);
    if (!(right.dot(step) < kFar)) continue;
    modes.segment(modes_.layout().begin(modes_.first_cluster() + c), step.size()) += step;
  }
}

}  // namespace silvafit::fit
