// SPDX-License-Identifier: MIT
// Random effects of the clusters of a model at a fit's estimates, and their uncertainty.
#pragma once

#include <vector>

#include "silvafit/fit/effect_uncertainty.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/nonlinear_model.hpp"
#include "variance/variance_kind.hpp"

namespace silvafit::fit {

/// The distribution of the random effects of groups before their observations are used, and its
/// dependence on the coefficients where it comes from a fit.
struct EffectPriors {
  /// Those that differ: block diagonal roots R of the covariance of the effects of all terms that
  /// act on a group, which are mean + R z with independent standard normal z. Groups of several
  /// terms have the same one.
  std::vector<MatrixXd> roots{};
  std::vector<Index> roots_of{};  ///< (G)
  std::vector<MatrixXd> means{};  ///< (q x groups) of each term
  /// (q p x groups) of each term: d mean / d beta', by columns; empty where all are zero.
  std::vector<MatrixXd> slopes{};
};

/// The random effects of one term with their uncertainty, in the order of the model's groups; NaN
/// for clusters whose effects were not found.
struct EffectPosterior {
  MatrixXd effects{};  ///< (q x groups)
  EffectUncertainty uncertainty{};
};

struct EffectPosteriors {
  std::vector<EffectPosterior> terms{};
  /// (triangle x cells) as EffectCells has them; empty with a single term
  MatrixXd curvatures{};
};

/// Finds the effects of each cluster, term by term: with held weights for lb, else the modes of the
/// density. \param threads  over blocks; the result does not depend on it
EffectPosteriors find_effects(const NonlinearModel& model,
                              const FittedModel& fit,
                              const EffectPriors& priors,
                              unsigned threads);

/// The same of groups of several terms, some of which are known from data that the model does not
/// have.
/// \param groups  one cluster with the cells of the earlier data, then those of the model
/// \param stored  (triangle x earlier cells) see EffectCells
/// \param priors  of groups, whose means are known for those with earlier cells
EffectPosteriors find_joint_effects(const NonlinearModel& model,
                                    const FittedModel& fit,
                                    const ModelGroups& groups,
                                    const MatrixXd& stored,
                                    const EffectPriors& priors);

/// Stores the uncertainty of a fit's random effects, for predictions without the data; nothing if
/// the fit failed.
void keep_uncertainty(const NonlinearModel& model, FittedModel& fit);

/// The uncertainty of effects that are known already, by a model that has a part of the
/// observations: the rounding of a group's sums depends on where its block begins.
/// \param blocks   first cluster of each block, and the end of the last; other clusters are NaN
/// \param typical  as VarianceData has it
EffectPosteriors describe_effects(const NonlinearModel& model,
                                  const FittedModel& fit,
                                  const std::vector<Index>& blocks,
                                  std::vector<TypicalValue> typical);

/// Priors of groups that were not in the fit.
EffectPriors priors_of_new_groups(const ModelGroups& groups, const FittedModel& fit);

}  // namespace silvafit::fit
