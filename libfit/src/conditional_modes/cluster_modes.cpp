// SPDX-License-Identifier: MIT
#include "conditional_modes/cluster_modes.hpp"

#include <algorithm>
#include <cmath>

#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

// Squared distance to the mode in standard deviations at which a search ends: 1e-9 of one, so that
// one Newton step suffices after the small changes of which Hessians are computed.
constexpr double kModeDecrement = 1e-18;
// Below this, Newton's steps converge without a line search, and rounding of the objective may hide
// their descent: a mean that is the difference of large terms has eleven digits left.
constexpr double kSettledDecrement = 1e-9;
// A Newton decrement below this that no longer falls is rounding.
constexpr double kRoundedDecrement = 1e-12;
// If modes only have to be distinguished from known ones.
constexpr double kRoughDecrement = 1e-8;
constexpr int kModeSteps = 100;
// Where the formula has a kink, a search ends this many standard deviations from it and goes on
// along it; each time takes some twenty steps.
constexpr double kKinkDistance = 1e-8;
constexpr int kKinkModeSteps = 1000;
// Up to this many rows of finished clusters are evaluated again, to keep the rows contiguous.
constexpr Index kGapRows = 128;

}  // namespace

ClusterModes::ClusterModes(const EffectLayout& layout,
                           const DensitySums& sums,
                           Index first,
                           Index last)
    : layout_(layout),
      sums_(sums),
      first_(first),
      last_(last),
      begin_(layout.first_cell(first)),
      end_(layout.first_cell(last)),
      r_(sums.random_count()),
      triangle_(r_ * (r_ + 1) / 2),
      clusters_(static_cast<std::size_t>(last - first)) {
  if (!sums.holds_weights()) return;
  weights_.first_row = sums.row_begin(begin_);
  weights_.own.setOnes(sums.row_begin(end_) - weights_.first_row);
  weights_.held = weights_.own;
}

void ClusterModes::begin(const VectorXd& modes) {
  z_ = modes.segment(layout_.begin(first_), layout_.begin(last_) - layout_.begin(first_));
  step_.resize(z_.size());
  density_.resize(sums_.density_count(), end_ - begin_);
  for (Cluster& cluster : clusters_) {
    cluster.objective = kInfinity;
    cluster.decrement = kInfinity;
    cluster.length = 1.0;
    cluster.is_done = false;
    cluster.has_failed = false;
    cluster.is_known = false;
    cluster.is_at_kink = false;
  }
  if (sums_.has_kinks()) accepted_ = density_;
}

void ClusterModes::end(VectorXd& modes) {
  // Sums of finished clusters may have been evaluated again, on one side of the kink.
  for (Index c = 0; c < cluster_count(); ++c) {
    if (is_at_kink(c)) sums_of(density_, c) = sums_of(accepted_, c);
  }
  modes.segment(layout_.begin(first_), z_.size()) = z_;
}

bool ClusterModes::search(const GroupPriors& priors,
                          VectorXd& modes,
                          MatrixXd& effects,
                          DensitySums::Workspace& workspace,
                          const VectorXd* known) {
  begin(modes);
  for (int step = 0; evaluate_open(priors, effects, workspace); ++step) {
    if (step == step_limit()) return false;
    for (Index c = 0; c < cluster_count(); ++c) {
      if (!clusters_[static_cast<std::size_t>(c)].is_done && !advance(priors, c, known)) {
        return false;
      }
    }
  }
  end(modes);
  return true;
}

void ClusterModes::search_each(const GroupPriors& priors,
                               VectorXd& modes,
                               MatrixXd& effects,
                               DensitySums::Workspace& workspace) {
  begin(modes);
  for (int step = 0; evaluate_open(priors, effects, workspace); ++step) {
    for (Index c = 0; c < cluster_count(); ++c) {
      Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
      if (cluster.is_done) continue;
      cluster.has_failed = step == step_limit() || !advance(priors, c, nullptr);
      if (cluster.has_failed) cluster.is_done = true;
    }
  }
  end(modes);
}

void ClusterModes::take(const MatrixXd& effects, DensitySums::Workspace& workspace) {
  sums_.density(begin_, end_, effects, density_, workspace, weights());
  for (Cluster& cluster : clusters_) {
    cluster.is_done = true;
    cluster.has_failed = false;
  }
}

void ClusterModes::place_effects(const GroupPriors& priors, Index cluster, MatrixXd& effects) {
  const auto z = of_cluster(z_, cluster);
  for (Index g = group_begin(cluster); g < group_begin(cluster + 1); ++g) {
    const SmallVector own = of_group(z, cluster, g - group_begin(cluster));
    effects.col(begin_ + g) = priors.design(begin_ + g).joint.lazyProduct(own);
    if (priors.offsets() != nullptr) effects.col(begin_ + g) += priors.offsets()->col(begin_ + g);
  }
}

/// Sums at the trial modes of all clusters whose search has not ended; false if there are none.
bool ClusterModes::evaluate_open(const GroupPriors& priors,
                                 MatrixXd& effects,
                                 DensitySums::Workspace& workspace) {
  const auto is_done = [&](Index c) { return clusters_[static_cast<std::size_t>(c)].is_done; };
  const auto first_row = [&](Index c) { return sums_.row_begin(begin_ + group_begin(c)); };
  bool any = false;
  for (Index c = 0; c < cluster_count(); ++c) {
    if (is_done(c)) continue;
    any = true;
    Index end = c;  // past the last open cluster of the run
    for (Index k = c; k < cluster_count() && first_row(k) - first_row(end) <= kGapRows; ++k) {
      if (is_done(k)) continue;
      place_effects(priors, k, effects);
      end = k + 1;
    }
    const Index from = group_begin(c);
    sums_.density(begin_ + from, begin_ + group_begin(end), effects, trial_, workspace, weights());
    density_.middleCols(from, trial_.cols()) = trial_;
    c = end - 1;
  }
  return any;
}

double ClusterModes::objective_of(Index cluster) const {
  const double sum = density_.row(0).segment(group_begin(cluster), group_count(cluster)).sum();
  return sum + 0.5 * of_cluster(z_, cluster).squaredNorm();
}

double ClusterModes::objective() const {
  double sum = 0.0;
  for (const Cluster& cluster : clusters_) sum += cluster.objective;
  return sum;
}

int ClusterModes::step_limit() const { return sums_.has_kinks() ? kKinkModeSteps : kModeSteps; }

/// Accepts the trial modes if they are better, and proposes the next; else shortens the step.
bool ClusterModes::advance(const GroupPriors& priors, Index c, const VectorXd* known) {
  Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
  const double reached = objective_of(c);
  const double rounding = 1e-13 * (1.0 + std::abs(cluster.objective));
  const double settled = sums_.has_kinks() ? kRoundedDecrement : kSettledDecrement;
  const bool is_settled = cluster.decrement < settled && std::isfinite(reached);
  // Without a share of the descent that the slope promises, steps would cross a kink to and fro.
  constexpr double kShare = 0.1;
  const double promised = sums_.has_kinks() && std::isfinite(cluster.objective)
                              ? kShare * cluster.length * cluster.decrement
                              : 0.0;
  const double last = cluster.decrement;
  if (!is_settled && !(reached <= cluster.objective - promised + rounding)) {
    if (!std::isfinite(cluster.objective)) return false;
    constexpr double kShortest = 1e-9;
    const bool is_at_kink = sums_.has_kinks() && std::isfinite(reached) &&
                            cluster.length * std::sqrt(cluster.decrement) < kKinkDistance;
    if (!is_at_kink) {
      if (cluster.length < kShortest) return false;
      move(c, -cluster.length);
      cluster.length *= sums_.has_kinks() && cluster.length < 0.1 ? 0.1 : 0.5;
      move(c, cluster.length);
      return true;
    }
    move(c, -cluster.length);
    if (!mix_sides(priors, c)) return false;
  } else {
    cluster.objective = reached;
    cluster.is_at_kink = false;
    if (sums_.holds_weights()) accept_weights(c);
  }
  if (!propose(priors, c)) return false;
  if (sums_.has_kinks()) sums_of(accepted_, c) = sums_of(density_, c);
  const bool is_rounding =
      cluster.decrement < kRoundedDecrement && cluster.decrement >= 0.25 * last;
  cluster.is_known = known != nullptr && leads_to(*known, c);
  // The slopes of the two sides belong to points that are this far from each other.
  constexpr double kKinkDecrement = 100.0 * kKinkDistance * kKinkDistance;
  const double precise = cluster.is_at_kink ? kKinkDecrement : kModeDecrement;
  const double enough = known != nullptr ? kRoughDecrement : precise;
  if (cluster.decrement < enough || is_rounding || cluster.is_known) {
    cluster.is_done = true;
    return true;
  }
  cluster.length = 1.0;
  move(c, 1.0);
  return true;
}

/// Where no step descends although the slope is not zero, the slope has a jump between the point
/// reached and the trial: replaces the sums of the point by the mixture of both whose Newton
/// decrement is least, which leads along the kink, or vanishes at a mode (the aggregate
/// subgradient of bundle methods; Kiwiel 1983, Math. Program. 27: 320-341).
bool ClusterModes::mix_sides(const GroupPriors& priors, Index c) {
  Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
  auto here = sums_of(density_, c);
  const auto kept = sums_of(accepted_, c);
  const MatrixXd change = here - kept;
  VectorXd slope = VectorXd::Zero(size_of(c));
  add_slopes(priors, c, change.middleRows(1, r_), slope);
  VectorXd solution = slope;
  cluster.hessian.solve(solution);
  const double across = slope.dot(of_cluster(step_, c));
  const double square = slope.dot(solution);
  const double share = std::min(across / square, 1.0);
  here = kept;
  if (!(share > 0.0)) return false;
  here.middleRows(1, here.rows() - 1) += share * change.bottomRows(here.rows() - 1);
  cluster.is_at_kink = true;
  return true;
}

/// Uses the weights of this point, and the objective with them, from now on.
void ClusterModes::accept_weights(Index c) {
  const Index from = sums_.row_begin(begin_ + group_begin(c)) - weights_.first_row;
  const Index to = sums_.row_begin(begin_ + group_begin(c + 1)) - weights_.first_row;
  weights_.held.segment(from, to - from) = weights_.own.segment(from, to - from);
  auto sums = sums_of(density_, c);
  sums.row(0) = sums.row(density_.rows() - 1);
  clusters_[static_cast<std::size_t>(c)].objective = objective_of(c);
}

/// Whether the next step leads almost straight to a known mode nearby.
bool ClusterModes::leads_to(const VectorXd& known, Index c) const {
  constexpr double kNear = 1.0;  // squared standard deviation
  constexpr double kShare = 0.05;
  if (!(clusters_[static_cast<std::size_t>(c)].decrement < kNear)) return false;
  const VectorXd away =
      of_cluster(z_, c) - known.segment(layout_.begin(first_ + c), of_cluster(z_, c).size());
  const double before = away.squaredNorm();
  const double after = (away + of_cluster(step_, c)).squaredNorm();
  return after <= kShare * kShare * before;
}

void ClusterModes::move(Index c, double length) {
  of_cluster(z_, c) += length * of_cluster(step_, c);
}

/// Adds slopes by a cluster's effects, from those by the coefficients of its groups.
/// \param slopes  (r x groups)
void ClusterModes::add_slopes(const GroupPriors& priors,
                              Index c,
                              const Eigen::Ref<const MatrixXd>& slopes,
                              Eigen::Ref<VectorXd> sum) const {
  for (Index k = 0; k < slopes.cols(); ++k) {
    const SmallMatrix& joint = priors.design(begin_ + group_begin(c) + k).joint;
    const SmallVector own = joint.transpose().lazyProduct(slopes.col(k));
    add_to_group(sum, c, k, own);
  }
}

/// The Newton step from the current modes.
bool ClusterModes::propose(const GroupPriors& priors, Index c) {
  Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
  if (!factorize(priors, c)) return false;
  auto step = of_cluster(step_, c);
  step = of_cluster(z_, c);
  add_slopes(priors, c, density_.block(1, group_begin(c), r_, group_count(c)), step);
  step = -step;
  right_ = step;
  cluster.hessian.solve(step);
  cluster.decrement = right_.dot(step);
  return std::isfinite(cluster.decrement);
}

/// Far from the mode the Hessian may have to be made positive definite.
bool ClusterModes::factorize(const GroupPriors& priors, Index c) {
  Cluster& cluster = clusters_[static_cast<std::size_t>(c)];
  EffectFactor& hessian = cluster.hessian;
  const Index first = begin_ + group_begin(c);
  cluster.is_convex = hessian.compute(pattern(c), priors, curvatures(c), first);
  if (cluster.is_convex) return true;
  constexpr double kLargestRidge = 1e12;
  for (double ridge = 1e-2; ridge < kLargestRidge; ridge *= 4.0) {
    if (hessian.compute(pattern(c), priors, curvatures(c), first, ridge)) return true;
  }
  return false;
}

}  // namespace silvafit::fit
