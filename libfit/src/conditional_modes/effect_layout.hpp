// SPDX-License-Identifier: MIT
// The random effects of all terms and groups as one vector.
#pragma once

#include <memory>
#include <vector>

#include "conditional_modes/sparse_factor.hpp"
#include "model/small_matrix.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The places of the random effects of all terms in one vector: cluster by cluster, so that a
/// search for the modes of some clusters has consecutive numbers; in a cluster term by term, and in
/// a term group by group.
class EffectLayout {
 public:
  explicit EffectLayout(const NonlinearModel& model);
  /// \param counts  number of effects of each term
  EffectLayout(const ModelGroups& groups, std::vector<Index> counts);

  Index size() const { return cluster_begin_.back(); }
  /// First place of a cluster; begin(C) is size().
  Index begin(Index cluster) const { return cluster_begin_[static_cast<std::size_t>(cluster)]; }
  /// First cell of a cluster.
  Index first_cell(Index cluster) const { return first_cell_[static_cast<std::size_t>(cluster)]; }
  std::size_t terms() const { return counts_.size(); }
  const std::vector<Index>& counts() const { return counts_; }
  /// Number of effects of a term.
  Index count(std::size_t term) const { return counts_[term]; }
  /// Number of effects of a cluster.
  Index size_of(Index cluster) const { return begin(cluster + 1) - begin(cluster); }
  /// The pattern of the Hessian of a cluster with crossed terms; null of nested ones.
  const SparsePattern* pattern(Index cluster) const {
    return patterns_.empty() ? nullptr : patterns_[static_cast<std::size_t>(cluster)].get();
  }
  /// Number of effects of all terms that act on one group of the model.
  Index joint_count() const { return shared_ + counts_.back(); }
  /// First place of the effects of group k of a term.
  Index at(std::size_t term, Index k) const { return places_[term][static_cast<std::size_t>(k)]; }

  /// The effects of all terms that act on a group of a cluster, from a vector of the cluster.
  /// \param k  the group's number in its cluster
  template <typename Vector>
  SmallVector of_group(const Vector& of_cluster, Index cluster, Index k) const {
    SmallVector result(joint_count());
    if (const SparsePattern* const crossed = pattern(cluster)) {
      for (Index i = 0; i < result.size(); ++i) {
        result[i] = of_cluster[crossed->place(i, k)];
      }
      return result;
    }
    result << of_cluster.head(shared_), of_cluster.segment(own(k), counts_.back());
    return result;
  }
  /// Adds to the effects of all terms that act on a group.
  template <typename Vector, typename Change>
  void add_to_group(Vector&& of_cluster, Index cluster, Index k, const Change& change) const {
    if (const SparsePattern* const crossed = pattern(cluster)) {
      for (Index i = 0; i < change.size(); ++i) {
        of_cluster[crossed->place(i, k)] += change[i];
      }
      return;
    }
    of_cluster.head(shared_) += change.head(shared_);
    of_cluster.segment(own(k), counts_.back()) += change.tail(counts_.back());
  }

  /// (q x G) effects of each term.
  std::vector<MatrixXd> by_term(const VectorXd& effects) const;
  VectorXd from_terms(const std::vector<MatrixXd>& terms) const;

 private:
  Index own(Index k) const { return shared_ + k * counts_.back(); }
  /// \param size  of the cluster, whose effects have their places already
  void add_pattern(const ModelGroups& groups, Index cluster, Index size);

  std::vector<Index> counts_;               ///< (q) of each term
  Index shared_ = 0;                        ///< effects of the terms before the last
  std::vector<Index> first_cell_;           ///< (C + 1)
  std::vector<Index> cluster_begin_;        ///< (C + 1)
  std::vector<std::vector<Index>> places_;  ///< (G) of each term
  std::vector<std::shared_ptr<const SparsePattern>> patterns_;  ///< of clusters, if crossed
};

}  // namespace silvafit::fit
