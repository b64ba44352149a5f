// SPDX-License-Identifier: MIT
// The factorized Hessian of the random effects of one cluster, nested or crossed.
#pragma once

#include <memory>
#include <vector>

#include "conditional_modes/arrow_factor.hpp"
#include "conditional_modes/sparse_factor.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// An arrow factor for nested groups, and a sparse one where the cluster has a pattern. See
/// ArrowFactor for the members.
class EffectFactor {
 public:
  /// \param pattern  of crossed groups, or null
  bool compute(const SparsePattern* pattern,
               const GroupPriors& priors,
               const Eigen::Ref<const MatrixXd>& curvatures,
               Index first = 0,
               double ridge = 0.0);

  double log_determinant() const {
    return sparse_ ? sparse_->factor.log_determinant() : arrow_.log_determinant();
  }
  double smallest_pivot() const {
    return sparse_ ? sparse_->factor.smallest_pivot() : arrow_.smallest_pivot();
  }
  void solve(Eigen::Ref<VectorXd> z) const {  // NOLINT: a view, whose values change
    sparse_ ? sparse_->factor.solve(z) : arrow_.solve(z);
  }
  /// Prepares inverse_block(); without effect for nested groups.
  void invert();
  SmallMatrix inverse_block(Index k) const {
    return sparse_ ? sparse_->factor.inverse_block(k) : arrow_.inverse_block(k);
  }

 private:
  /// With linear models the Hessian is often that of the evaluation before, and its factorization
  /// takes most of the time.
  struct Sparse {
    SparseFactor factor{};
    const SparsePattern* pattern = nullptr;
    std::vector<SmallMatrix> joints{};  ///< the design if all cells share it, else empty
    MatrixXd curvatures{};
    double ridge = 0.0;
    bool is_factorized = false;
    bool is_inverted = false;
  };

  ArrowFactor arrow_;
  std::unique_ptr<Sparse> sparse_;
};

}  // namespace silvafit::fit
