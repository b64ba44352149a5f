// SPDX-License-Identifier: MIT
// The modes of the random effects of some clusters given the data.
#pragma once

#include <vector>

#include "conditional_modes/effect_factor.hpp"
#include "conditional_modes/effect_layout.hpp"
#include "conditional_modes/observation_sums.hpp"
#include "silvafit/fit/matrices.hpp"

namespace silvafit::fit {

/// Spherical random effects z of consecutive clusters, independent standard normal, and Newton's
/// search for their modes: the minimum of sum rho + |z|^2/2 of each cluster; with held weights, the
/// point where its slope is zero at the weights of the point itself. Memory is kept between
/// searches.
class ClusterModes {
 public:
  /// Clusters [first, last) of the layout.
  ClusterModes(const EffectLayout& layout, const DensitySums& sums, Index first, Index last);

  /// Searches from given modes.
  /// \param modes    (layout) of the model, in: starts; out: modes
  /// \param effects  (r x G), out: changes of the coefficients of each group
  /// \param known    (layout) modes of the model, or null: a search that comes near them ends
  ///   there, and others only have to be distinguished from them
  /// \returns false if the search of a cluster failed, which ends the others
  bool search(const GroupPriors& priors,
              VectorXd& modes,
              MatrixXd& effects,
              DensitySums::Workspace& workspace,
              const VectorXd* known = nullptr);
  /// The same for each cluster separately; is_found() tells whether its search succeeded.
  void search_each(const GroupPriors& priors,
                   VectorXd& modes,
                   MatrixXd& effects,
                   DensitySums::Workspace& workspace);
  /// Uses given effects as the modes; without the standard normal effects that they consist of.
  /// \param effects  (r x G)
  void take(const MatrixXd& effects, DensitySums::Workspace& workspace);

  Index first_cluster() const { return first_; }
  Index first_group() const { return begin_; }
  Index end_group() const { return end_; }
  Index cluster_count() const { return last_ - first_; }
  /// First group of a cluster, by its number from 0, counted from first_group().
  Index group_begin(Index cluster) const { return layout_.first_cell(first_ + cluster) - begin_; }

  /// At the modes: the objective of all clusters, and Hessians.
  double objective() const;
  double objective(Index cluster) const {
    return clusters_[static_cast<std::size_t>(cluster)].objective;
  }
  bool is_found(Index cluster) const {
    return clusters_[static_cast<std::size_t>(cluster)].is_done &&
           !clusters_[static_cast<std::size_t>(cluster)].has_failed;
  }
  /// Whether the search came near a known mode.
  bool is_known(Index cluster) const {
    return clusters_[static_cast<std::size_t>(cluster)].is_known;
  }
  const EffectFactor& hessian(Index cluster) const {
    return clusters_[static_cast<std::size_t>(cluster)].hessian;
  }
  EffectFactor& hessian(Index cluster) {
    return clusters_[static_cast<std::size_t>(cluster)].hessian;
  }
  /// Whether the search ended at a minimum. At a saddle point, where the gradient is zero, the
  /// Hessian has an added ridge.
  bool is_minimum(Index cluster) const {
    return clusters_[static_cast<std::size_t>(cluster)].is_convex;
  }
  /// Whether the mode is at a kink of the formula, where the density has no curvature: slopes and
  /// curvatures are then those of the mixture of the two sides whose slope is zero.
  bool is_at_kink(Index cluster) const {
    return clusters_[static_cast<std::size_t>(cluster)].is_at_kink;
  }
  /// The modes of all clusters, from layout().begin(first_cluster()) on.
  const VectorXd& modes() const { return z_; }
  const EffectLayout& layout() const { return layout_; }
  /// The pattern of a cluster's Hessian; see EffectLayout.
  const SparsePattern* pattern(Index cluster) const { return layout_.pattern(first_ + cluster); }
  /// The effects of all terms that act on a group, by its number in a cluster; and their sum.
  /// \param of_cluster  vector of the effects of the cluster
  template <typename Vector>
  SmallVector of_group(const Vector& of_cluster, Index cluster, Index k) const {
    return layout_.of_group(of_cluster, first_ + cluster, k);
  }
  template <typename Vector, typename Change>
  void add_to_group(Vector&& of_cluster, Index cluster, Index k, const Change& change) const {
    layout_.add_to_group(of_cluster, first_ + cluster, k, change);
  }
  /// Number of effects of a cluster.
  Index size_of(Index cluster) const {
    return layout_.begin(first_ + cluster + 1) - layout_.begin(first_ + cluster);
  }
  /// The part of a vector of these clusters' effects that belongs to a cluster.
  template <typename Vector>
  auto of_cluster(Vector&& effects, Index cluster) const {
    const Index begin = layout_.begin(first_ + cluster) - layout_.begin(first_);
    return effects.segment(begin, size_of(cluster));
  }
  /// The sums of density terms at the modes, one column a group.
  const MatrixXd& density() const { return density_; }
  /// (r) d rho / d b, summed over a group
  auto slope(Index group) const { return density_.col(group).segment(1, r_); }
  /// (triangle x groups of the cluster) second derivatives by b
  auto curvatures(Index cluster) const {
    return density_.block(1 + r_, group_begin(cluster), triangle_, group_count(cluster));
  }
  /// The same of the matrix K in the log-determinant.
  auto approximations(Index cluster) const {
    const Index row = 1 + r_ + (sums_.has_approximation() ? triangle_ : 0);
    return density_.block(row, group_begin(cluster), triangle_, group_count(cluster));
  }
  Index group_count(Index cluster) const { return group_begin(cluster + 1) - group_begin(cluster); }

 private:
  struct Cluster {
    double objective = 0.0;
    double decrement = 0.0;
    double length = 1.0;  ///< of the step that is tried
    bool is_done = false;
    bool has_failed = false;
    bool is_known = false;
    bool is_convex = false;  ///< at the modes, without a ridge
    bool is_at_kink = false;
    EffectFactor hessian{};
  };
  void begin(const VectorXd& modes);
  void end(VectorXd& modes);
  bool evaluate_open(const GroupPriors& priors,
                     MatrixXd& effects,
                     DensitySums::Workspace& workspace);
  void place_effects(const GroupPriors& priors, Index cluster, MatrixXd& effects);
  bool advance(const GroupPriors& priors, Index cluster, const VectorXd* known);
  int step_limit() const;
  bool mix_sides(const GroupPriors& priors, Index cluster);
  void accept_weights(Index cluster);
  HeldWeights* weights() { return sums_.holds_weights() ? &weights_ : nullptr; }
  bool leads_to(const VectorXd& known, Index cluster) const;
  bool propose(const GroupPriors& priors, Index cluster);
  bool factorize(const GroupPriors& priors, Index cluster);
  auto sums_of(MatrixXd& sums, Index cluster) const {
    return sums.middleCols(group_begin(cluster), group_count(cluster));
  }
  void add_slopes(const GroupPriors& priors,
                  Index cluster,
                  const Eigen::Ref<const MatrixXd>& slopes,
                  Eigen::Ref<VectorXd> sum) const;
  void move(Index cluster, double length);
  double objective_of(Index cluster) const;

  const EffectLayout& layout_;
  const DensitySums& sums_;
  Index first_;
  Index last_;
  Index begin_;
  Index end_;
  Index r_;
  Index triangle_;
  std::vector<Cluster> clusters_;
  VectorXd z_;
  VectorXd step_;
  VectorXd right_;    ///< of a Newton system
  MatrixXd density_;  ///< sums of density terms, one column a group
  MatrixXd trial_;
  MatrixXd accepted_;  ///< density_ at the points reached, if the formula has kinks
  HeldWeights weights_;
};

}  // namespace silvafit::fit
