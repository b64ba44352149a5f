// SPDX-License-Identifier: MIT
// The factorised Hessian of the random effects of one cluster.
#pragma once

#include <Eigen/Cholesky>
#include <span>
#include <vector>

#include "small_matrix.hpp"

namespace silvafit::fit {

/// How the spherical random effects of a cluster move the coefficients: those of group k of the
/// cluster move by outer * u + inner * v_k. r coefficients are random in some grouping.
struct RandomDesign {
  SmallMatrix outer{};  ///< (r x s) without a coarser grouping s = 0
  SmallMatrix inner{};  ///< (r x q)
};

/// The Cholesky factor of H = I + Lambda' A Lambda for (u, v_1 .. v_m): a matrix in the shape of an
/// arrow, since groups of a cluster meet only through u. With s = 0 it is block diagonal.
class ArrowFactor {
 public:
  /// \param curvatures  (m) matrices A_k (r x r)
  /// \param ridge       added to the diagonal
  /// \returns false if H is not positive definite
  bool compute(const RandomDesign& design,
               std::span<const SmallMatrix> curvatures,
               double ridge = 0.0);

  double log_determinant() const;
  /// Solves H (u, v) = right side, in place.
  void solve(SmallVector& u, std::span<SmallVector> v) const;
  /// The block of H^-1 that belongs to (u, v_k), (s + q x s + q).
  SmallMatrix inverse_block(std::size_t k) const;
  /// The lower factor of the only group's block; for s = 0.
  SmallMatrix lower(std::size_t k) const { return groups_[k].factor.matrixL(); }

 private:
  struct Group {
    Eigen::LLT<SmallMatrix> factor{};
    SmallMatrix coupling{};  ///< (s x q) block of H for u and v_k
    SmallMatrix solved{};    ///< (q x s) H_kk^-1 coupling'
  };
  std::vector<Group> groups_;
  std::size_t count_ = 0;
  bool has_outer_ = false;
  Eigen::LLT<SmallMatrix> complement_;  ///< of the Schur complement for u
};

}  // namespace silvafit::fit
