// SPDX-License-Identifier: MIT
#include "conditional_modes/effect_posteriors.hpp"

#include <utility>

#include "conditional_modes/cluster_modes.hpp"
#include "conditional_modes/random_places.hpp"
#include "model/covariance_factor.hpp"
#include "model/variance_weights.hpp"
#include "result/earlier_fit.hpp"
#include "result/group_coefficients.hpp"
#include "result/nested_effects.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows of a block of clusters: their data stay in the cache while effects are searched.
constexpr Index kRowsOfBlock = 4096;

/// The density that a method's random effects are modes of. Laplace's method and quadrature have
/// the same one as FOCEI; only their log-determinants differ.
Curvature curvature_of(Method method) {
  if (method == Method::kLindstromBates) return Curvature::kHeldWeights;
  return method == Method::kFirstOrder ? Curvature::kFirstOrder : Curvature::kExpected;
}

RandomDesign design_of(const EffectRoots& roots, const RandomPlaces& places) {
  RandomDesign design{.outer = SmallMatrix::Zero(places.r(), places.s()),
                      .inner = SmallMatrix::Zero(places.r(), places.q())};
  add_placed(roots.outer, places.outer_rows, design.outer);
  add_placed(roots.coupling, places.inner_rows, design.outer);
  add_placed(roots.inner, places.inner_rows, design.inner);
  return design;
}

EffectPosteriors empty_posteriors(const NonlinearModel& model, const RandomPlaces& places) {
  const Index s = places.s();
  const Index q = places.q();
  const Index p = model.coefficient_count();
  const Index groups = model.group_count();
  const Index clusters = s > 0 ? model.cluster_count() : 0;
  EffectPosteriors result;
  result.inner.setConstant(q, groups, kNaN);
  result.inner_uncertainty = {.covariances = MatrixXd::Constant(q * q, groups, kNaN),
                              .sensitivities = MatrixXd::Constant(q * p, groups, kNaN),
                              .cross_covariances = MatrixXd::Constant(q * s, groups, kNaN)};
  result.outer.setConstant(s, clusters, kNaN);
  result.outer_uncertainty = {.covariances = MatrixXd::Constant(s * s, clusters, kNaN),
                              .sensitivities = MatrixXd::Constant(s * p, clusters, kNaN)};
  return result;
}

/// What all blocks of clusters share.
struct Setting {
  const NonlinearModel& model;
  const EffectPriors& priors;
  const RandomPlaces& places;
  const ObservationSums& sums;
  const GroupPriors& designs;
  bool is_linearized = false;  ///< conditional covariances are those of the linearized model
};

/// The uncertainty of the effects of consecutive clusters given the data, once the modes are known.
class BlockPosteriors {
 public:
  BlockPosteriors(const Setting& shared, const ClusterModes& modes)
      : shared_(shared), modes_(modes) {}

  /// \param effects  (r x G) the modes
  void describe(const MatrixXd& effects,
                const Modes& spherical,
                ObservationSums::Workspace& workspace,
                EffectPosteriors& result) {
    shared_.sums.mixed(modes_.first_group(), modes_.end_group(), effects, mixed_, workspace);
    for (Index c = 0; c < modes_.cluster_count(); ++c) {
      if (modes_.is_found(c)) describe_cluster(c, spherical, result);
    }
  }

 private:
  bool factorize(Index c, bool is_exact) {
    const Index first = modes_.first_group() + modes_.group_begin(c);
    return shared_.designs.factorize(
        first, is_exact ? modes_.curvatures(c) : modes_.approximations(c), 0.0, factor_);
  }

  /// (r x p) the derivative of a group's slope by the coefficients, effects held.
  MatrixXd by_coefficients(Index group, const SmallMatrix& curvature) const {
    const Index r = shared_.places.r();
    MatrixXd result(r, shared_.model.coefficient_count());
    for (Index c = 0; c < r; ++c) {
      result.col(shared_.places.all[static_cast<std::size_t>(c)]) = curvature.col(c);
    }
    const std::vector<Index>& others = shared_.sums.others();
    for (std::size_t o = 0; o < others.size(); ++o) {
      result.col(others[o]) = mixed_.col(group).segment(static_cast<Index>(o) * r, r);
    }
    return result;
  }

  /// (r x p) the derivatives of the means of a group's prior by the coefficients.
  MatrixXd shift_of(Index cluster, Index group) const {
    const RandomPlaces& places = shared_.places;
    const Index p = shared_.model.coefficient_count();
    MatrixXd shift = MatrixXd::Zero(places.r(), p);
    const MatrixXd own = shared_.priors.inner_slope.col(group).reshaped(places.q(), p);
    for (Index i = 0; i < places.q(); ++i) shift.row(places.inner_rows[i]) += own.row(i);
    if (places.s() == 0) return shift;
    const MatrixXd of = shared_.priors.outer_slope.col(cluster).reshaped(places.s(), p);
    for (Index i = 0; i < places.s(); ++i) shift.row(places.outer_rows[i]) += of.row(i);
    return shift;
  }

  /// d z / d beta' of a cluster, a column a coefficient: (s x p) and (q m x p).
  void follow(Index c, MatrixXd& outer, MatrixXd& inner) {
    const Index r = shared_.places.r();
    const Index q = shared_.places.q();
    const Index s = shared_.places.s();
    const Index p = shared_.model.coefficient_count();
    const Index groups = modes_.group_count(c);
    outer.setZero(s, p);
    inner.setZero(q * groups, p);
    for (Index k = 0; k < groups; ++k) {
      const Index g = modes_.group_begin(c) + k;
      const RandomDesign& design = shared_.designs.design(modes_.first_group() + g);
      const VectorXd triangle = modes_.curvatures(c).col(k);
      const SmallMatrix curvature = unpacked(triangle.data(), r);
      MatrixXd change = by_coefficients(g, curvature);
      if (shared_.priors.inner_slope.size() > 0) {
        change += curvature * shift_of(modes_.first_cluster() + c, modes_.first_group() + g);
      }
      inner.middleRows(q * k, q) = -design.inner.transpose() * change;
      if (s > 0) outer -= design.outer.transpose() * change;
    }
    if (!factorize(c, true) && !factorize(c, false)) {
      inner.setConstant(kNaN);
      return;
    }
    VectorXd u;
    MatrixXd v;
    for (Index j = 0; j < p; ++j) {
      u = outer.col(j);
      v = inner.col(j).reshaped(q, groups);
      factor_.solve(u, v);
      outer.col(j) = u;
      inner.col(j) = v.reshaped();
    }
  }

  void describe_cluster(Index c, const Modes& spherical, EffectPosteriors& result) {
    MatrixXd by_outer;
    MatrixXd by_inner;
    follow(c, by_outer, by_inner);
    const bool is_exact = !shared_.is_linearized && factorize(c, true);
    if (!is_exact && !factorize(c, false)) return;
    const Index q = shared_.places.q();
    for (Index k = 0; k < modes_.group_count(c); ++k) {
      const MatrixXd own = by_inner.middleRows(q * k, q);
      describe_group(c, k, by_outer, own, spherical, result);
    }
  }

  void describe_group(Index c,
                      Index k,
                      const MatrixXd& by_outer,
                      const MatrixXd& by_inner,
                      const Modes& spherical,
                      EffectPosteriors& result) const {
    const Index s = shared_.places.s();
    const Index q = shared_.places.q();
    const Index g = modes_.first_group() + modes_.group_begin(c) + k;
    const EffectPriors& priors = shared_.priors;
    const EffectRoots& roots =
        priors.roots[static_cast<std::size_t>(priors.roots_of[static_cast<std::size_t>(g)])];
    MatrixXd transform = MatrixXd::Zero(s + q, s + q);
    transform.topLeftCorner(s, s) = roots.outer;
    if (s > 0) transform.bottomLeftCorner(q, s) = roots.coupling;
    transform.bottomRightCorner(q, q) = roots.inner;
    const MatrixXd inverse = factor_.inverse_block(k);
    const MatrixXd covariance = transform * inverse * transform.transpose();
    result.inner_uncertainty.covariances.col(g) = covariance.bottomRightCorner(q, q).reshaped();
    MatrixXd slope = roots.inner * by_inner;
    if (s > 0) slope += roots.coupling * by_outer;
    if (priors.inner_slope.size() > 0) {
      slope += priors.inner_slope.col(g).reshaped(slope.rows(), slope.cols());
    }
    result.inner_uncertainty.sensitivities.col(g) = slope.reshaped();
    result.inner.col(g) = priors.inner_mean.col(g) + roots.inner * spherical.inner.col(g);
    if (s == 0) return;
    const Index of = modes_.first_cluster() + c;
    result.inner.col(g) += roots.coupling * spherical.outer.col(of);
    result.inner_uncertainty.cross_covariances.col(g) =
        covariance.bottomLeftCorner(q, s).reshaped();
    if (k > 0) return;
    result.outer.col(of) = priors.outer_mean.col(of) + roots.outer * spherical.outer.col(of);
    result.outer_uncertainty.covariances.col(of) = covariance.topLeftCorner(s, s).reshaped();
    MatrixXd outer_slope = roots.outer * by_outer;
    if (priors.outer_slope.size() > 0) {
      outer_slope += priors.outer_slope.col(of).reshaped(s, by_outer.cols());
    }
    result.outer_uncertainty.sensitivities.col(of) = outer_slope.reshaped();
  }

  const Setting& shared_;
  const ClusterModes& modes_;
  MatrixXd mixed_;
  ArrowFactor factor_;
};

/// The estimates of a fit as sums are evaluated at them.
ObservationPoint point_of(const NonlinearModel& model,
                          const VarianceModel& variance,
                          const FittedModel& fit) {
  const ResidualVariance residual = residual_variance_for(fit, model);
  return {.beta = fit.estimate,
          .variance = variance.parameters(residual.variance),
          .log_sigma = variance.log_scale_of(residual.variance, residual.sigma)};
}

/// First clusters of blocks, and the end of the last block.
std::vector<Index> blocks_of(const NonlinearModel& model) {
  std::vector<Index> result{0};
  for (Index c = 0; c < model.cluster_count(); ++c) {
    const Index rows = model.group_begin(model.cluster_begin(c + 1)) -
                       model.group_begin(model.cluster_begin(result.back()));
    if (rows >= kRowsOfBlock || c + 1 == model.cluster_count()) result.push_back(c + 1);
  }
  return result;
}

/// \param known  (r x G) effects that are used as the solution, or null to search
EffectPosteriors run(const NonlinearModel& model,
                     const FittedModel& fit,
                     const EffectPriors& priors,
                     unsigned threads,
                     const MatrixXd* known,
                     const std::vector<Index>& blocks,
                     std::vector<double> typical = {}) {
  const RandomPlaces places(model);
  VarianceData data = VarianceData::of(model);
  data.typical = std::move(typical);
  const VarianceModel variance(model.specification().variance, std::move(data));
  ObservationSums sums(model, variance, curvature_of(fit.method), places.all, false);
  sums.set_point(point_of(model, variance, fit));
  std::vector<RandomDesign> designs;
  for (const EffectRoots& roots : priors.roots) designs.push_back(design_of(roots, places));
  std::vector<const RandomDesign*> of_groups;
  for (const Index of : priors.roots_of)
    of_groups.push_back(&designs[static_cast<std::size_t>(of)]);
  MatrixXd offsets = MatrixXd::Zero(places.r(), model.group_count());
  add_group_effects(model,
                    {.rows = places.inner_rows, .effects = priors.inner_mean},
                    {.rows = places.outer_rows, .effects = priors.outer_mean},
                    offsets);
  const GroupPriors group_priors(std::move(of_groups), offsets);
  const Setting shared{.model = model,
                       .priors = priors,
                       .places = places,
                       .sums = sums,
                       .designs = group_priors,
                       .is_linearized = fit.method == Method::kLindstromBates};
  EffectPosteriors result = empty_posteriors(model, places);
  Modes spherical{.outer = MatrixXd::Zero(places.s(), model.cluster_count()),
                  .inner = MatrixXd::Zero(places.q(), model.group_count())};
  MatrixXd effects = known != nullptr ? *known : MatrixXd(places.r(), model.group_count());
  parallel_for(blocks.size() - 1, threads, [&](std::size_t b) {
    ObservationSums::Workspace workspace;
    ClusterModes modes(model, sums, blocks[b], blocks[b + 1]);
    if (known != nullptr) {
      modes.take(effects, workspace);
    } else {
      modes.search_each(group_priors, spherical, effects, workspace);
    }
    BlockPosteriors(shared, modes).describe(effects, spherical, workspace, result);
  });
  return result;
}

}  // namespace

EffectPriors priors_of_new_groups(const NonlinearModel& model, const FittedModel& fit) {
  const auto q = static_cast<Index>(finer(fit).names.size());
  const auto s = static_cast<Index>(coarser(fit).names.size());
  EffectPriors priors;
  priors.roots.push_back({.outer = covariance_factor(coarser(fit).covariance),
                          .coupling = MatrixXd::Zero(q, s),
                          .inner = covariance_factor(finer(fit).covariance)});
  priors.roots_of.assign(static_cast<std::size_t>(model.group_count()), 0);
  priors.inner_mean.setZero(q, model.group_count());
  priors.outer_mean.setZero(s, s > 0 ? model.cluster_count() : 0);
  return priors;
}

EffectPosteriors find_effects(const NonlinearModel& model,
                              const FittedModel& fit,
                              const EffectPriors& priors,
                              unsigned threads) {
  return run(model, fit, priors, threads, nullptr, blocks_of(model));
}

EffectPosteriors describe_effects(const NonlinearModel& model, const FittedModel& fit) {
  return describe_effects(model, fit, blocks_of(model), {});
}

EffectPosteriors describe_effects(const NonlinearModel& model,
                                  const FittedModel& fit,
                                  const std::vector<Index>& blocks,
                                  std::vector<double> typical) {
  const RandomPlaces places(model);
  MatrixXd effects = MatrixXd::Zero(places.r(), model.group_count());
  add_group_effects(model,
                    {.rows = places.inner_rows, .effects = finer(fit).effects},
                    {.rows = places.outer_rows, .effects = coarser(fit).effects},
                    effects);
  return run(model,
             fit,
             priors_of_new_groups(model, fit),
             model.threads(),
             &effects,
             blocks,
             std::move(typical));
}

}  // namespace silvafit::fit
