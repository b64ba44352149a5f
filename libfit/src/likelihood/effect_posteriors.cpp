// SPDX-License-Identifier: MIT
#include "likelihood/effect_posteriors.hpp"

#include <memory>
#include <utility>

#include "conditional_modes/cluster_modes.hpp"
#include "conditional_modes/random_places.hpp"
#include "conditional_modes/stored_cells.hpp"
#include "model/model_groups.hpp"
#include "model/symmetric_eigen.hpp"
#include "model/variance_weights.hpp"
#include "result/earlier_fit.hpp"
#include "result/group_coefficients.hpp"
#include "silvafit/base/constants.hpp"
#include "silvafit/base/parallel.hpp"

namespace silvafit::fit {
namespace {

// Rows of a block of clusters: their data stay in the cache while effects are searched.
constexpr Index kRowsOfBlock = 4096;

/// The density that a method's random effects are modes of. Laplace's method and quadrature have
/// the same one as FOCEI; only their log-determinants differ.
Curvature density_of(Method method) {
  if (method == Method::kLindstromBates) return Curvature::kHeldWeights;
  return method == Method::kFirstOrder ? Curvature::kFirstOrder : Curvature::kExpected;
}

RandomDesign design_of(const MatrixXd& root, const RandomPlaces& places) {
  RandomDesign design{.joint = SmallMatrix::Zero(places.r(), root.cols()),
                      .shared = root.cols() - places.q(places.terms.size() - 1)};
  Index row = 0;
  for (const std::vector<Index>& rows : places.rows) {
    const auto count = static_cast<Index>(rows.size());
    add_placed(root.middleRows(row, count), rows, 0, design.joint);
    row += count;
  }
  return design;
}

/// Missing values.
EffectPosteriors empty_posteriors(const ModelGroups& groups, Index p, const RandomPlaces& places) {
  EffectPosteriors result;
  for (std::size_t t = 0; t < places.terms.size(); ++t) {
    const Index q = places.q(t);
    const Index count = std::ssize(groups.labels[t]);
    result.terms.push_back(
        {.effects = MatrixXd::Constant(q, count, kNaN),
         .uncertainty = {.covariances = MatrixXd::Constant(q * q, count, kNaN),
                         .sensitivities = MatrixXd::Constant(q * p, count, kNaN)}});
  }
  const Index r = places.r();
  if (result.terms.size() > 1) {
    result.curvatures.setConstant(r * (r + 1) / 2, groups.cell_count(), kNaN);
  }
  return result;
}

/// What all blocks of clusters share.
struct Setting {
  const ModelGroups& groups;
  Index columns = 0;  ///< coefficients, also those with random effects only
  const EffectPriors& priors;
  const RandomPlaces& places;
  const EffectLayout& layout;
  const DensitySums& sums;
  const GroupPriors& designs;
  Index stored = 0;            ///< number of cells whose data are known by their curvature only
  bool is_linearized = false;  ///< conditional covariances are those of the linearized model
};

/// A cell.
struct GroupPlace {
  Index cluster = 0;
  Index group = 0;       ///< among all groups
  Index in_cluster = 0;  ///< its number in the cluster
};

/// The uncertainty of the effects of consecutive clusters given the data, once the modes are known.
class BlockPosteriors {
 public:
  BlockPosteriors(const Setting& shared, const ClusterModes& modes)
      : shared_(shared), modes_(modes) {}

  /// \param effects    (r x G) the modes
  /// \param spherical  (layout) the same
  void describe(const MatrixXd& effects,
                const VectorXd& spherical,
                DensitySums::Workspace& workspace,
                EffectPosteriors& result) {
    shared_.sums.mixed(modes_.first_group(), modes_.end_group(), effects, mixed_, workspace);
    for (Index c = 0; c < modes_.cluster_count(); ++c) {
      if (modes_.is_found(c)) describe_cluster(c, spherical, result);
    }
  }

 private:
  bool factorize(Index c, bool is_exact) {
    const Index first = modes_.first_group() + modes_.group_begin(c);
    return factor_.compute(modes_.pattern(c),
                           shared_.designs,
                           is_exact ? modes_.curvatures(c) : modes_.approximations(c),
                           first);
  }

  /// (r x p) the derivative of a group's slope by the coefficients, effects held.
  MatrixXd by_coefficients(Index group, const SmallMatrix& curvature) const {
    const Index r = shared_.places.r();
    MatrixXd result(r, shared_.columns);
    for (Index c = 0; c < r; ++c) {
      result.col(shared_.places.all[static_cast<std::size_t>(c)]) = curvature.col(c);
    }
    const std::vector<Index>& others = shared_.sums.others();
    for (std::size_t o = 0; o < others.size(); ++o) {
      result.col(others[o]) = mixed_.col(group).segment(static_cast<Index>(o) * r, r);
    }
    return result;
  }

  /// The column of a group in matrices of a term.
  Index column(std::size_t term, const GroupPlace& at) const {
    return shared_.groups.group_of(term, at.group);
  }

  /// (s + q x columns) numbers of all terms that belong to a group.
  /// \param of_terms  (q columns x groups) of each term
  MatrixXd joint(const std::vector<MatrixXd>& of_terms, const GroupPlace& at, Index columns) const {
    MatrixXd result(shared_.layout.joint_count(), columns);
    Index row = 0;
    for (std::size_t t = 0; t < of_terms.size(); ++t) {
      const Index q = shared_.layout.count(t);
      result.middleRows(row, q) = of_terms[t].col(column(t, at)).reshaped(q, columns);
      row += q;
    }
    return result;
  }

  /// (r x p) the derivatives of the means of a group's prior by the coefficients.
  MatrixXd shift_of(const GroupPlace& at) const {
    const Index p = shared_.columns;
    MatrixXd shift = MatrixXd::Zero(shared_.places.r(), p);
    for (std::size_t t = 0; t < shared_.priors.slopes.size(); ++t) {
      const auto own = shared_.priors.slopes[t].col(column(t, at));
      shift(shared_.places.rows[t], Eigen::all) += own.reshaped(shared_.layout.count(t), p);
    }
    return shift;
  }

  /// (size x p) d z / d beta' of a cluster; NaN where it is not known.
  MatrixXd follow(Index c) {
    const Index p = shared_.columns;
    MatrixXd result = MatrixXd::Zero(modes_.size_of(c), p);
    for (Index k = 0; k < modes_.group_count(c); ++k) {
      const GroupPlace at = place(c, k);
      if (at.group < shared_.stored) continue;  // its density moves with the prior's mean
      const VectorXd triangle = modes_.curvatures(c).col(k);
      const SmallMatrix curvature = unpacked(triangle.data(), shared_.places.r());
      MatrixXd change = by_coefficients(modes_.group_begin(c) + k, curvature);
      if (!shared_.priors.slopes.empty()) change += curvature * shift_of(at);
      const MatrixXd by_effects = -shared_.designs.design(at.group).joint.transpose() * change;
      for (Index j = 0; j < p; ++j) modes_.add_to_group(result.col(j), c, k, by_effects.col(j));
    }
    if (!factorize(c, true) && !factorize(c, false)) {
      result.setConstant(kNaN);
      return result;
    }
    for (Index j = 0; j < p; ++j) factor_.solve(result.col(j));
    return result;
  }

  GroupPlace place(Index c, Index k) const {
    return {.cluster = modes_.first_cluster() + c,
            .group = modes_.first_group() + modes_.group_begin(c) + k,
            .in_cluster = k};
  }

  void describe_cluster(Index c, const VectorXd& spherical, EffectPosteriors& result) {
    const MatrixXd by_beta = follow(c);
    const bool is_exact = !shared_.is_linearized && factorize(c, true);
    if (!is_exact && !factorize(c, false)) return;
    if (result.terms.size() > 1) {
      result.curvatures.middleCols(modes_.first_group() + modes_.group_begin(c),
                                   modes_.group_count(c)) =
          is_exact ? modes_.curvatures(c) : modes_.approximations(c);
    }
    factor_.invert();
    const VectorXd z =
        spherical.segment(shared_.layout.begin(modes_.first_cluster() + c), modes_.size_of(c));
    for (Index k = 0; k < modes_.group_count(c); ++k) {
      describe_group(place(c, k), by_beta, z, result.terms);
    }
  }

  /// \param by_beta  (size x p) derivatives of the effects of the group's cluster
  /// \param z        (size) these effects
  void describe_group(const GroupPlace& at,
                      const MatrixXd& by_beta,
                      const VectorXd& z,
                      std::vector<EffectPosterior>& result) const {
    const EffectLayout& layout = shared_.layout;
    const EffectPriors& priors = shared_.priors;
    const MatrixXd& root =
        priors.roots[static_cast<std::size_t>(priors.roots_of[static_cast<std::size_t>(at.group)])];
    const MatrixXd covariance = root * factor_.inverse_block(at.in_cluster) * root.transpose();
    MatrixXd own(layout.joint_count(), by_beta.cols());
    for (Index j = 0; j < own.cols(); ++j) {
      own.col(j) = layout.of_group(by_beta.col(j), at.cluster, at.in_cluster);
    }
    MatrixXd slope = root * own;
    if (!priors.slopes.empty()) slope += joint(priors.slopes, at, slope.cols());
    const VectorXd effects =
        joint(priors.means, at, 1) + root * layout.of_group(z, at.cluster, at.in_cluster);
    Index row = 0;
    for (std::size_t t = 0; t < result.size(); ++t) {
      const Index q = layout.count(t);
      const Index k = column(t, at);
      EffectUncertainty& of = result[t].uncertainty;
      const bool is_last = t + 1 == result.size();
      if (shared_.groups.is_crossed || is_last || at.in_cluster == 0) {
        result[t].effects.col(k) = effects.segment(row, q);
        of.covariances.col(k) = covariance.block(row, row, q, q).reshaped();
        of.sensitivities.col(k) = slope.middleRows(row, q).reshaped();
      }
      row += q;
    }
  }

  const Setting& shared_;
  const ClusterModes& modes_;
  MatrixXd mixed_;
  EffectFactor factor_;
};

/// The estimates of a fit as sums are evaluated at them.
ObservationPoint point_of(const NonlinearModel& model,
                          const VarianceModel& variance,
                          const FittedModel& fit) {
  const ResidualVariance residual = residual_variance_for(fit, model);
  return {.beta = model.extended(fit.estimate),
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

/// The sums of a model at a fit's estimates.
class SumsAtFit {
 public:
  SumsAtFit(const NonlinearModel& model, const FittedModel& fit, std::vector<TypicalValue> typical)
      : variance_(model.specification().variance, data_of(model, fit, std::move(typical))),
        sums_(make_group_sums(
            model, variance_, density_of(fit.method), RandomPlaces(model).all, false)) {
    sums_->set_point(point_of(model, variance_, fit));
  }
  const GroupSums& sums() const { return *sums_; }

 private:
  static VarianceData data_of(const NonlinearModel& model,
                              const FittedModel& fit,
                              std::vector<TypicalValue> typical) {
    const auto& correlation = fit.variance.correlation;
    VarianceData data = VarianceData::of(model, correlation ? &*correlation : nullptr);
    data.typical = std::move(typical);
    return data;
  }

  VarianceModel variance_;
  std::unique_ptr<GroupSums> sums_;
};

struct Search {
  const ModelGroups& groups;
  const DensitySums& sums;
  const EffectPriors& priors;
  std::vector<Index> blocks{};      ///< see describe_effects
  const MatrixXd* known = nullptr;  ///< (r x cells) effects that are the solution; null to search
  Index stored = 0;                 ///< see Setting
  unsigned threads = 1;
};

EffectPosteriors run(const NonlinearModel& model, const FittedModel& fit, const Search& how) {
  const RandomPlaces places(model);
  const EffectLayout layout(how.groups, EffectLayout(model).counts());
  std::vector<RandomDesign> designs;
  for (const MatrixXd& root : how.priors.roots) designs.push_back(design_of(root, places));
  std::vector<const RandomDesign*> of_groups;
  for (const Index of : how.priors.roots_of)
    of_groups.push_back(&designs[static_cast<std::size_t>(of)]);
  MatrixXd offsets = MatrixXd::Zero(places.r(), how.groups.cell_count());
  add_group_effects(how.groups, places.rows, how.priors.means, offsets);
  const GroupPriors group_priors(std::move(of_groups), offsets);
  const Setting shared{.groups = how.groups,
                       .columns = model.column_count(),
                       .priors = how.priors,
                       .places = places,
                       .layout = layout,
                       .sums = how.sums,
                       .designs = group_priors,
                       .stored = how.stored,
                       .is_linearized = fit.method == Method::kLindstromBates};
  EffectPosteriors result = empty_posteriors(how.groups, model.column_count(), places);
  VectorXd spherical = VectorXd::Zero(layout.size());
  MatrixXd effects = how.known != nullptr ? *how.known : MatrixXd(places.r(), offsets.cols());
  parallel_for(how.blocks.size() - 1, how.threads, [&](std::size_t b) {
    DensitySums::Workspace workspace;
    ClusterModes modes(layout, how.sums, how.blocks[b], how.blocks[b + 1]);
    if (how.known != nullptr) {
      modes.take(effects, workspace);
    } else {
      modes.search_each(group_priors, spherical, effects, workspace);
    }
    BlockPosteriors(shared, modes).describe(effects, spherical, workspace, result);
  });
  return result;
}

}  // namespace

EffectPriors priors_of_new_groups(const ModelGroups& groups, const FittedModel& fit) {
  EffectPriors priors;
  Index size = 0;
  for (std::size_t t = 0; t < fit.random.size(); ++t) {
    const Index q = fit.random[t].covariance.rows();
    priors.means.emplace_back(MatrixXd::Zero(q, std::ssize(groups.labels[t])));
    size += q;
  }
  MatrixXd& root = priors.roots.emplace_back(MatrixXd::Zero(size, size));
  Index row = 0;
  for (const EstimatedEffects& term : fit.random) {
    const Index q = term.covariance.rows();
    root.block(row, row, q, q) = covariance_factor(term.covariance);
    row += q;
  }
  priors.roots_of.assign(static_cast<std::size_t>(groups.cell_count()), 0);
  return priors;
}

EffectPosteriors find_effects(const NonlinearModel& model,
                              const FittedModel& fit,
                              const EffectPriors& priors,
                              unsigned threads) {
  const SumsAtFit at(model, fit, {});
  return run(model,
             fit,
             {.groups = model.groups(),
              .sums = at.sums(),
              .priors = priors,
              .blocks = blocks_of(model),
              .threads = threads});
}

EffectPosteriors find_joint_effects(const NonlinearModel& model,
                                    const FittedModel& fit,
                                    const ModelGroups& groups,
                                    const MatrixXd& stored,
                                    const EffectPriors& priors) {
  const SumsAtFit at(model, fit, {});
  const RandomPlaces places(model);
  MatrixXd centers = MatrixXd::Zero(places.r(), groups.cell_count());
  add_group_effects(groups, places.rows, priors.means, centers);
  const StoredCells sums(stored, centers.leftCols(stored.cols()), at.sums());
  return run(model,
             fit,
             {.groups = groups,
              .sums = sums,
              .priors = priors,
              .blocks = {0, 1},
              .stored = stored.cols()});
}

void keep_uncertainty(const NonlinearModel& model, FittedModel& fit) {
  if (!fit.has_random_effects() || !(fit.sigma > 0.0)) return;
  if (!fit.random.back().effects.allFinite()) return;
  EffectPosteriors described = describe_effects(model, fit, blocks_of(model), {});
  for (std::size_t t = 0; t < described.terms.size(); ++t) {
    fit.random[t].uncertainty = std::move(described.terms[t].uncertainty);
  }
  if (model.term_count() < 2) return;
  fit.cells = {.groups = model.groups().of_cells, .curvatures = std::move(described.curvatures)};
}

EffectPosteriors describe_effects(const NonlinearModel& model,
                                  const FittedModel& fit,
                                  const std::vector<Index>& blocks,
                                  std::vector<TypicalValue> typical) {
  const RandomPlaces places(model);
  MatrixXd effects = MatrixXd::Zero(places.r(), model.group_count());
  add_group_effects(model.groups(), places.rows, effects_of(fit), effects);
  const SumsAtFit at(model, fit, std::move(typical));
  return run(model,
             fit,
             {.groups = model.groups(),
              .sums = at.sums(),
              .priors = priors_of_new_groups(model.groups(), fit),
              .blocks = blocks,
              .known = &effects,
              .threads = model.threads()});
}

}  // namespace silvafit::fit
