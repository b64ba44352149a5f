// SPDX-License-Identifier: MIT
// The factorized Hessian of the random effects of one cluster of nested groups.
#pragma once

#include <vector>

#include "conditional_modes/group_priors.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// The Cholesky factor of H = I + Lambda' A Lambda for (u, v_1 .. v_m) of a cluster, the order of
/// EffectLayout. H is an arrow matrix, since groups of a cluster are connected only through u. With
/// s = 0 it is block diagonal.
///
/// The inner loop of marginal likelihoods: memory is reused, and matrices are multiplied element by
/// element, because they are too small for other methods to be faster.
class ArrowFactor {
 public:
  /// \param curvatures  (r (r + 1) / 2 x m) lower triangles by columns of the matrices A_k
  /// \param first       the cluster's first group among those of the priors
  /// \param ridge       added to the diagonal
  /// \returns false if H is not positive definite
  bool compute(const GroupPriors& priors,
               const Eigen::Ref<const MatrixXd>& curvatures,
               Index first = 0,
               double ridge = 0.0);

  double log_determinant() const;
  /// The smallest pivot: the ratio of the information on an effect, given the data and the effects
  /// before it, to that of its own distribution (1 if the data have none).
  double smallest_pivot() const { return smallest_pivot_; }
  /// Solves H z = right side, in place.
  /// \param z  (s + q m)
  void solve(Eigen::Ref<VectorXd> z) const;
  /// The block of H^-1 that belongs to (u, v_k), (s + q x s + q).
  SmallMatrix inverse_block(Index k) const;

 private:
  using Map = Eigen::Map<MatrixXd>;
  using ConstMap = Eigen::Map<const MatrixXd>;
  // Each group has a factor (q x q), the block of H for u and v_k (s x q), and (q x s) the solution
  // of its transpose with the factor; the factor for u follows.
  double* group(Index k) { return memory_.data() + k * (q_ * q_ + 2 * s_ * q_); }
  const double* group(Index k) const { return memory_.data() + k * (q_ * q_ + 2 * s_ * q_); }
  void resize(Index s, Index q, Index m);

  Index s_ = 0;
  Index q_ = 0;
  Index m_ = 0;
  std::vector<double> memory_;
  double log_determinant_ = 0.0;  ///< without the factors in product_
  double product_ = 1.0;
  double smallest_pivot_ = 0.0;
};

/// The symmetric matrix of a lower triangle stored by columns.
/// \param triangle  (size (size + 1) / 2)
SmallMatrix unpacked(const double* triangle, Index size);

}  // namespace silvafit::fit
