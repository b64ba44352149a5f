// SPDX-License-Identifier: MIT
#include "conditional_modes/calibration_block.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "conditional_modes/rounded_decrement.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Squared distance to the solution in standard deviations at which a search ends.
constexpr double kFoundDecrement = 1e-20;
constexpr int kSteps = 200;
constexpr double kShortestStep = 1e-9;

/// The clusters of consecutive rows.
class Block {
 public:
  Block(const CalibrationSetting& shared, Index first, Index last)
      : shared_(shared),
        first_(first),
        last_(last),
        begin_(shared.model.cluster_begin(first)),
        end_(shared.model.cluster_begin(last)),
        row_(shared.model.group_begin(begin_)),
        clusters_(static_cast<std::size_t>(last - first)) {
    for (Index c = first_; c < last_; ++c) {
      Cluster& cluster = clusters_[static_cast<std::size_t>(c - first_)];
      for (Index g = shared.model.cluster_begin(c); g < shared.model.cluster_begin(c + 1); ++g) {
        const Index of = shared.priors.roots_of[static_cast<std::size_t>(g)];
        cluster.designs.push_back(&shared.designs[static_cast<std::size_t>(of)]);
      }
    }
    z_outer_.setZero(shared.places.s(), last - first);
    z_inner_.setZero(shared.places.q(), end_ - begin_);
    outer_step_ = z_outer_;
    inner_step_ = z_inner_;
  }

  /// \param effects, held, own  room for all groups and rows, of which the block's own are used
  void search(MatrixXd& effects, VectorXd& held, VectorXd& own) {
    place_effects(effects);
    shared_.terms.evaluate(begin_, end_, effects, held, own, sums_, workspace_);
    accept_weights(held, own);
    for (Cluster& cluster : clusters_) start(cluster);
    for (int step = 0; step < kSteps && is_open(); ++step) {
      place_effects(effects);
      shared_.terms.evaluate(begin_, end_, effects, held, own, trial_, workspace_);
      for (Index c = 0; c < last_ - first_; ++c) advance(c, held, own);
    }
    for (Cluster& cluster : clusters_) cluster.is_found = cluster.is_found && cluster.is_done;
    place_effects(effects);
  }

  /// Takes given effects as the solution.
  void take(MatrixXd& effects, VectorXd& held, VectorXd& own) {
    shared_.terms.evaluate(begin_, end_, effects, held, own, sums_, workspace_);
    for (Cluster& cluster : clusters_) cluster.is_found = cluster.is_done = true;
  }

  void describe(const MatrixXd& effects, EffectPosteriors& result) {
    MatrixXd by_fixed;
    shared_.terms.by_coefficients(begin_, end_, effects, by_fixed, workspace_);
    for (Index c = 0; c < last_ - first_; ++c) describe_cluster(c, by_fixed, result);
  }

 private:
  struct Cluster {
    double objective = 0.0;
    double decrement = std::numeric_limits<double>::infinity();
    double length = 1.0;
    bool is_done = false;
    bool is_found = false;
    std::vector<const RandomDesign*> designs{};
    ArrowFactor factor{};
  };

  Index group_begin(Index c) const { return shared_.model.cluster_begin(first_ + c) - begin_; }
  Index group_count(Index c) const { return group_begin(c + 1) - group_begin(c); }
  bool is_open() const {
    return std::ranges::any_of(clusters_, [](const Cluster& cluster) { return !cluster.is_done; });
  }

  void place_effects(MatrixXd& effects) const {
    for (Index c = 0; c < last_ - first_; ++c) {
      const auto& designs = clusters_[static_cast<std::size_t>(c)].designs;
      for (Index k = 0; k < group_count(c); ++k) {
        const Index g = group_begin(c) + k;
        const RandomDesign& design = *designs[static_cast<std::size_t>(k)];
        effects.col(begin_ + g) = shared_.offsets.col(begin_ + g);
        effects.col(begin_ + g) += design.inner.lazyProduct(z_inner_.col(g));
        if (design.outer.cols() > 0) {
          effects.col(begin_ + g) += design.outer.lazyProduct(z_outer_.col(c));
        }
      }
    }
  }

  void accept_weights(VectorXd& held, const VectorXd& own) const {
    if (!shared_.terms.holds_weights()) return;
    const Index rows = shared_.model.group_begin(end_) - row_;
    held.segment(row_, rows) = own.segment(row_, rows);
  }

  double penalty(Index c) const {
    return 0.5 * (z_outer_.col(c).squaredNorm() +
                  z_inner_.middleCols(group_begin(c), group_count(c)).squaredNorm());
  }
  double objective_of(Index c, const MatrixXd& sums, Index row) const {
    return penalty(c) + sums.row(row).segment(group_begin(c), group_count(c)).sum();
  }

  void start(Cluster& cluster) {
    const Index c = &cluster - clusters_.data();
    cluster.objective = objective_of(c, sums_, 1);
    if (!std::isfinite(cluster.objective) || !propose(c, sums_)) {
      cluster.is_done = true;
      return;
    }
    settle(c);
  }

  /// Whether the search of a cluster has ended; else moves to the next trial.
  void settle(Index c, double last = std::numeric_limits<double>::infinity()) {
    Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
    const bool is_rounding =
        cluster.decrement < kRoundedDecrement && cluster.decrement >= 0.25 * last;
    if (cluster.decrement < kFoundDecrement || is_rounding) {
      cluster.is_done = cluster.is_found = true;
      return;
    }
    cluster.length = 1.0;
    move(c, 1.0);
  }

  /// Takes the trial if it is better, and proposes the next; else goes back half way.
  void advance(Index c, VectorXd& held, const VectorXd& own) {
    Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
    if (cluster.is_done) return;
    const double reached = objective_of(c, trial_, 0);
    const double rounding = 1e-13 * (1.0 + std::abs(cluster.objective));
    if (!(reached <= cluster.objective + rounding)) {
      cluster.length *= 0.5;
      if (cluster.length < kShortestStep) {
        // Without held weights this is rounding, if the solution is near.
        move(c, -2.0 * cluster.length);
        cluster.is_done = true;
        cluster.is_found = cluster.decrement < kRoundedDecrement;
      } else {
        move(c, -cluster.length);
      }
      return;
    }
    const Index groups = group_count(c);
    sums_.middleCols(group_begin(c), groups) = trial_.middleCols(group_begin(c), groups);
    cluster.objective = objective_of(c, sums_, 1);
    if (shared_.terms.holds_weights()) {
      const Index from = shared_.model.group_begin(begin_ + group_begin(c));
      const Index rows = shared_.model.group_begin(begin_ + group_begin(c + 1)) - from;
      held.segment(from, rows) = own.segment(from, rows);
    }
    const double last = cluster.decrement;
    if (!propose(c, sums_)) {
      cluster.is_done = true;
      return;
    }
    settle(c, last);
  }

  void move(Index c, double length) {
    z_outer_.col(c) += length * outer_step_.col(c);
    z_inner_.middleCols(group_begin(c), group_count(c)) +=
        length * inner_step_.middleCols(group_begin(c), group_count(c));
  }

  auto triangles(Index c, const MatrixXd& sums, bool is_exact) const {
    const Index row = is_exact ? shared_.terms.curvature_row() : shared_.terms.expected_row();
    return sums.block(row, group_begin(c), shared_.terms.triangle(), group_count(c));
  }

  /// Newton's step, with the expected curvature where the exact one is not positive definite.
  bool propose(Index c, const MatrixXd& sums) {
    Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
    if (!cluster.factor.compute(cluster.designs, triangles(c, sums, true)) &&
        !cluster.factor.compute(cluster.designs, triangles(c, sums, false))) {
      return false;
    }
    VectorXd outer = -z_outer_.col(c);
    MatrixXd inner = -z_inner_.middleCols(group_begin(c), group_count(c));
    const Index r = shared_.terms.random_count();
    for (Index k = 0; k < inner.cols(); ++k) {
      const auto slope = sums.col(group_begin(c) + k).segment(shared_.terms.slope_row(), r);
      const RandomDesign& design = *cluster.designs[static_cast<std::size_t>(k)];
      inner.col(k) -= design.inner.transpose().lazyProduct(slope);
      if (outer.size() > 0) outer -= design.outer.transpose().lazyProduct(slope);
    }
    const VectorXd outer_right = outer;
    const MatrixXd inner_right = inner;
    cluster.factor.solve(outer, inner);
    cluster.decrement = outer_right.dot(outer) + inner_right.cwiseProduct(inner).sum();
    outer_step_.col(c) = outer;
    inner_step_.middleCols(group_begin(c), group_count(c)) = inner;
    return std::isfinite(cluster.decrement);
  }

  /// d z / d beta' of a cluster, a column a coefficient: (s x p) and (q m x p).
  void follow(Index c, const MatrixXd& by_fixed, MatrixXd& outer, MatrixXd& inner) {
    Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
    const Index r = shared_.terms.random_count();
    const Index q = shared_.places.q();
    const Index s = shared_.places.s();
    const Index p = by_fixed.rows() / r;
    const Index groups = group_count(c);
    outer.setZero(s, p);
    inner.setZero(q * groups, p);
    for (Index k = 0; k < groups; ++k) {
      const Index g = group_begin(c) + k;
      const RandomDesign& design = *cluster.designs[static_cast<std::size_t>(k)];
      MatrixXd change = by_fixed.col(g).reshaped(r, p);
      if (shared_.priors.inner_slope.size() > 0) {
        // The means of the priors move with the coefficients, too.
        MatrixXd shift = MatrixXd::Zero(r, p);
        const MatrixXd own = shared_.priors.inner_slope.col(begin_ + g).reshaped(q, p);
        for (Index i = 0; i < q; ++i) shift.row(shared_.places.inner_rows[i]) += own.row(i);
        if (s > 0) {
          const MatrixXd of = shared_.priors.outer_slope.col(first_ + c).reshaped(s, p);
          for (Index i = 0; i < s; ++i) shift.row(shared_.places.outer_rows[i]) += of.row(i);
        }
        const SmallMatrix curvature =
            unpacked(sums_.col(g)
                         .segment(shared_.terms.curvature_row(), shared_.terms.triangle())
                         .eval()
                         .data(),
                     r);
        change += curvature * shift;
      }
      inner.middleRows(q * k, q) = -design.inner.transpose() * change;
      if (s > 0) outer -= design.outer.transpose() * change;
    }
    if (!cluster.factor.compute(cluster.designs, triangles(c, sums_, true)) &&
        !cluster.factor.compute(cluster.designs, triangles(c, sums_, false))) {
      inner.setConstant(kNaN);
      return;
    }
    VectorXd u;
    MatrixXd v;
    for (Index j = 0; j < p; ++j) {
      u = outer.col(j);
      v = inner.col(j).reshaped(q, groups);
      cluster.factor.solve(u, v);
      outer.col(j) = u;
      inner.col(j) = v.reshaped();
    }
  }

  void describe_cluster(Index c, const MatrixXd& by_fixed, EffectPosteriors& result) {
    Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
    if (!cluster.is_found) return;
    const Index s = shared_.places.s();
    const Index q = shared_.places.q();
    MatrixXd by_outer;
    MatrixXd by_inner;
    follow(c, by_fixed, by_outer, by_inner);
    const bool is_exact = !shared_.is_linearized;
    if (!(is_exact && cluster.factor.compute(cluster.designs, triangles(c, sums_, true))) &&
        !cluster.factor.compute(cluster.designs, triangles(c, sums_, false))) {
      return;
    }
    const EffectPriors& priors = shared_.priors;
    for (Index k = 0; k < group_count(c); ++k) {
      const Index g = begin_ + group_begin(c) + k;
      const EffectRoots& roots =
          priors.roots[static_cast<std::size_t>(priors.roots_of[static_cast<std::size_t>(g)])];
      const MatrixXd inverse = cluster.factor.inverse_block(k);
      MatrixXd transform = MatrixXd::Zero(s + q, s + q);
      transform.topLeftCorner(s, s) = roots.outer;
      if (s > 0) transform.bottomLeftCorner(q, s) = roots.coupling;
      transform.bottomRightCorner(q, q) = roots.inner;
      const MatrixXd covariance = transform * inverse * transform.transpose();
      result.inner_uncertainty.covariances.col(g) = covariance.bottomRightCorner(q, q).reshaped();
      MatrixXd slope = roots.inner * by_inner.middleRows(q * k, q);
      if (s > 0) slope += roots.coupling * by_outer;
      if (priors.inner_slope.size() > 0) {
        slope += priors.inner_slope.col(g).reshaped(slope.rows(), slope.cols());
      }
      result.inner_uncertainty.sensitivities.col(g) = slope.reshaped();
      result.inner.col(g) = priors.inner_mean.col(g) + roots.inner * z_inner_.col(g - begin_);
      if (s == 0) continue;
      result.inner.col(g) += roots.coupling * z_outer_.col(c);
      result.inner_uncertainty.cross_covariances.col(g) =
          covariance.bottomLeftCorner(q, s).reshaped();
      if (k > 0) continue;
      const Index of = first_ + c;
      result.outer.col(of) = priors.outer_mean.col(of) + roots.outer * z_outer_.col(c);
      result.outer_uncertainty.covariances.col(of) = covariance.topLeftCorner(s, s).reshaped();
      MatrixXd outer_slope = roots.outer * by_outer;
      if (priors.outer_slope.size() > 0) {
        outer_slope += priors.outer_slope.col(of).reshaped(s, by_outer.cols());
      }
      result.outer_uncertainty.sensitivities.col(of) = outer_slope.reshaped();
    }
  }

  const CalibrationSetting& shared_;
  Index first_;
  Index last_;
  Index begin_;
  Index end_;
  Index row_;
  std::vector<Cluster> clusters_;
  MatrixXd z_outer_;
  MatrixXd z_inner_;
  MatrixXd outer_step_;
  MatrixXd inner_step_;
  MatrixXd sums_;
  MatrixXd trial_;
  CalibrationTerms::Workspace workspace_;
};

}  // namespace

void calibrate_block(const CalibrationSetting& setting,
                     Index first,
                     Index last,
                     bool is_known,
                     MatrixXd& effects,
                     VectorXd& held,
                     VectorXd& own,
                     EffectPosteriors& result) {
  Block block(setting, first, last);
  if (is_known) {
    block.take(effects, held, own);
  } else {
    block.search(effects, held, own);
  }
  block.describe(effects, result);
}

}  // namespace silvafit::fit
