// SPDX-License-Identifier: MIT
#include "likelihood/correlated_effects.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "likelihood/linearization.hpp"
#include "result/earlier_fit.hpp"
#include "result/estimated_terms.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VarianceModel variance_of(const NonlinearModel& model, const FittedModel& fit) {
  return {model.specification().variance, VarianceData::of(model, &*fit.variance.correlation)};
}

/// Effects are mean + R z of each group, with z standard normal: those of the terms before the last
/// one, common to the groups of a cluster, then those of the group's own.
class EffectSearch {
 public:
  EffectSearch(const NonlinearModel& model, const FittedModel& fit, const EffectPriors& priors)
      : model_(model),
        priors_(priors),
        random_(model.random_coefficients()),
        variance_(variance_of(model, fit)),
        linearizer_(model, variance_) {
    const Index p = model.coefficient_count();
    const ResidualVariance residual = residual_variance_for(fit, model);
    point_ = {.coefficients = fit.estimate,
              .effects = MatrixXd::Zero(p, model.group_count()),
              .variance = variance_.parameters(residual.variance),
              .units = VectorXd::Ones(p)};
    const double sigma = std::exp(variance_.log_scale_of(residual.variance, residual.sigma));
    precision_ = 1.0 / (sigma * sigma);
    for (const std::vector<Index>& columns : random_) joint_ += std::ssize(columns);
    shared_ = joint_ - std::ssize(random_.back());
    places_ = MatrixXd::Zero(p, joint_);
    Index row = 0;
    for (const std::vector<Index>& columns : random_) {
      for (const Index column : columns) places_(column, row++) = 1.0;
    }
  }

  /// The posteriors at given effects.
  /// \param effects  (q x groups) of each term
  std::vector<EffectPosterior> at(const std::vector<MatrixXd>& effects) {
    add_group_effects(model_, random_, effects, point_.effects);
    is_found_.assign(clusters(), linearizer_.linearize(point_, false, nullptr, at_));
    std::vector<EffectPosterior> result = posteriors();
    for (std::size_t t = 0; t < result.size(); ++t) result[t].effects = effects[t];
    return result;
  }

  std::vector<EffectPosterior> found() {
    constexpr int kSteps = 100;
    constexpr double kReached = 1e-16;  // squared standard errors
    for (Index c = 0; c < model_.cluster_count(); ++c) z_.emplace_back(VectorXd::Zero(size(c)));
    is_found_.assign(clusters(), false);
    place();
    bool is_valid = linearizer_.linearize(point_, false, nullptr, at_);
    for (int step = 0; step < kSteps && is_valid; ++step) {
      std::vector<VectorXd> change(clusters());
      bool is_complete = true;
      for (Index c = 0; c < model_.cluster_count(); ++c) {
        const auto k = static_cast<std::size_t>(c);
        const System system = system_of(c);
        const VectorXd target = system.hessian.llt().solve(system.right);
        change[k] = target - z_[k];
        is_found_[k] = change[k].dot(system.hessian * change[k]) <= kReached;
        is_complete = is_complete && is_found_[k];
      }
      if (is_complete) return posteriors();
      is_valid = move(change);
    }
    if (!is_valid) is_found_.assign(clusters(), false);
    return posteriors();
  }

 private:
  struct System {
    MatrixXd hessian;  ///< of the penalized squares over two by z
    VectorXd right;
    MatrixXd by_coefficients;  ///< (size x p)
  };

  std::size_t clusters() const { return static_cast<std::size_t>(model_.cluster_count()); }
  Index own() const { return joint_ - shared_; }
  Index groups(Index c) const { return model_.cluster_begin(c + 1) - model_.cluster_begin(c); }
  Index size(Index c) const { return shared_ + groups(c) * own(); }
  const MatrixXd& root(Index group) const {
    const Index of = priors_.roots_of[static_cast<std::size_t>(group)];
    return priors_.roots[static_cast<std::size_t>(of)];
  }

  /// The places of a group's effects among those of its cluster.
  std::vector<Index> places_of(Index c, Index group) const {
    std::vector<Index> result;
    for (Index k = 0; k < shared_; ++k) result.push_back(k);
    const Index begin = shared_ + (group - model_.cluster_begin(c)) * own();
    for (Index k = 0; k < own(); ++k) result.push_back(begin + k);
    return result;
  }

  /// (joint x columns) what all terms have for a group.
  MatrixXd joined(const std::vector<MatrixXd>& of_terms, Index group, Index columns) const {
    MatrixXd result = MatrixXd::Zero(joint_, columns);
    Index row = 0;
    for (std::size_t t = 0; t < of_terms.size(); ++t) {
      const Index q = std::ssize(random_[t]);
      result.middleRows(row, q) = of_terms[t].col(model_.group_of(t, group)).reshaped(q, columns);
      row += q;
    }
    return result;
  }

  System system_of(Index c) const {
    const Index p = model_.coefficient_count();
    System result{.hessian = MatrixXd::Identity(size(c), size(c)),
                  .right = VectorXd::Zero(size(c)),
                  .by_coefficients = MatrixXd::Zero(size(c), p)};
    for (Index g = model_.cluster_begin(c); g < model_.cluster_begin(c + 1); ++g) {
      const Eigen::Map<const MatrixXd> products(at_.model.moments.term(g, 0), p + 1, p + 1);
      const MatrixXd half = precision_ * root(g).transpose() * places_.transpose() *
                            products.topRows(p);  // (joint x p + 1)
      const MatrixXd by_effects = half.leftCols(p) * places_;
      const std::vector<Index> at = places_of(c, g);
      result.hessian(at, at) += by_effects * root(g);
      result.right(at) += half.col(p) - by_effects * joined(priors_.means, g, 1);
      result.by_coefficients(at, Eigen::all) +=
          half.leftCols(p) + by_effects * joined(priors_.slopes, g, p);
    }
    return result;
  }

  /// Sets the effects of all groups from z.
  void place() {
    for (Index c = 0; c < model_.cluster_count(); ++c) {
      for (Index g = model_.cluster_begin(c); g < model_.cluster_begin(c + 1); ++g) {
        point_.effects.col(g) = places_ * effects_of(c, g);
      }
    }
  }
  VectorXd effects_of(Index c, Index g) const {
    const VectorXd own = z_[static_cast<std::size_t>(c)](places_of(c, g));
    return joined(priors_.means, g, 1) + root(g) * own;
  }

  /// The penalized squares of each cluster.
  VectorXd objectives(const VectorXd& squares) const {
    VectorXd result(model_.cluster_count());
    for (Index c = 0; c < result.size(); ++c) {
      result[c] = precision_ * squares.segment(model_.cluster_begin(c), groups(c)).sum() +
                  z_[static_cast<std::size_t>(c)].squaredNorm();
    }
    return result;
  }

  /// Moves each cluster as far as its penalized squares do not increase.
  bool move(const std::vector<VectorXd>& change) {
    constexpr int kTrials = 30;
    const std::vector<VectorXd> from = z_;
    const VectorXd before = objectives(at_.squares);
    VectorXd length = VectorXd::Ones(model_.cluster_count());
    for (int trial = 0; trial < kTrials; ++trial) {
      for (std::size_t c = 0; c < z_.size(); ++c) {
        z_[c] = from[c] + length[static_cast<Index>(c)] * change[c];
      }
      place();
      Linearization there;
      const bool is_valid = linearizer_.linearize(point_, false, &at_, there);
      const VectorXd after = objectives(there.squares_before);
      bool is_lower = is_valid;
      for (Index c = 0; c < length.size(); ++c) {
        if (after[c] <= before[c] * (1.0 + 1e-12)) continue;
        length[c] *= 0.5;
        is_lower = false;
      }
      if (!is_lower) continue;
      at_ = std::move(there);
      return true;
    }
    return false;
  }

  std::vector<EffectPosterior> posteriors() const {
    const Index p = model_.coefficient_count();
    std::vector<EffectPosterior> result;
    Index before = 0;
    for (std::size_t t = 0; t < random_.size(); ++t) {
      const Index q = std::ssize(random_[t]);
      const Index count = model_.group_count(t);
      result.push_back(
          {.effects = MatrixXd::Constant(q, count, kNaN),
           .uncertainty = {.covariances = MatrixXd::Constant(q * q, count, kNaN),
                           .sensitivities = MatrixXd::Constant(q * p, count, kNaN),
                           .cross_covariances = MatrixXd::Constant(q * before, count, kNaN)}});
      before += q;
    }
    for (Index c = 0; c < model_.cluster_count(); ++c) {
      if (is_found_[static_cast<std::size_t>(c)]) describe(c, result);
    }
    return result;
  }

  void describe(Index c, std::vector<EffectPosterior>& result) const {
    const Index p = model_.coefficient_count();
    const System system = system_of(c);
    const MatrixXd inverse = system.hessian.llt().solve(MatrixXd::Identity(size(c), size(c)));
    const MatrixXd by_coefficients = -inverse * system.by_coefficients;
    for (Index g = model_.cluster_begin(c); g < model_.cluster_begin(c + 1); ++g) {
      const std::vector<Index> at = places_of(c, g);
      const MatrixXd covariance = root(g) * inverse(at, at) * root(g).transpose();
      const MatrixXd slope =
          joined(priors_.slopes, g, p) + root(g) * by_coefficients(at, Eigen::all);
      Index row = 0;
      for (std::size_t t = 0; t < result.size(); ++t) {
        const Index q = std::ssize(random_[t]);
        const Index k = model_.group_of(t, g);
        EffectUncertainty& of = result[t].uncertainty;
        if (!z_.empty()) result[t].effects.col(k) = effects_of(c, g).segment(row, q);
        of.covariances.col(k) = covariance.block(row, row, q, q).reshaped();
        of.sensitivities.col(k) = slope.middleRows(row, q).reshaped();
        of.cross_covariances.col(k) = covariance.block(row, 0, q, row).reshaped();
        row += q;
      }
    }
  }

  const NonlinearModel& model_;
  const EffectPriors& priors_;
  std::vector<std::vector<Index>> random_;
  VarianceModel variance_;
  Linearizer linearizer_;
  LinearizationPoint point_;
  Linearization at_;
  double precision_ = 1.0;
  Index joint_ = 0;   ///< effects of all terms on a group
  Index shared_ = 0;  ///< those before the last term
  MatrixXd places_;   ///< (p x joint) 1 where an effect belongs to a coefficient
  std::vector<VectorXd> z_;
  std::vector<bool> is_found_;
};

}  // namespace

std::vector<EffectPosterior> find_correlated_effects(const NonlinearModel& model,
                                                     const FittedModel& fit,
                                                     const EffectPriors& priors) {
  return EffectSearch(model, fit, priors).found();
}

std::vector<EffectPosterior> describe_correlated_effects(const NonlinearModel& model,
                                                         const FittedModel& fit) {
  const EffectPriors priors = priors_of_new_groups(model, fit);
  return EffectSearch(model, fit, priors).at(effects_of(fit));
}

}  // namespace silvafit::fit
