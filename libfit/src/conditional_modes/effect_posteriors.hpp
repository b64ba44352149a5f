// SPDX-License-Identifier: MIT
// Random effects of the clusters of a model at a fit's estimates, and their uncertainty.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "silvafit/fit/effect_uncertainty.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The distribution of the random effects of a cluster's groups before their observations are used,
/// by independent standard normal z: u = mean + outer z_u, v = mean + coupling z_u + inner z_v.
struct EffectRoots {
  Eigen::MatrixXd outer{};     ///< (s x s)
  Eigen::MatrixXd coupling{};  ///< (q x s)
  Eigen::MatrixXd inner{};     ///< (q x q)
};

/// The same of all groups. Means depend on the coefficients where they come from a fit.
struct EffectPriors {
  std::vector<EffectRoots> roots{};      ///< those that differ
  std::vector<Eigen::Index> roots_of{};  ///< (G) groups of a cluster share `outer`
  Eigen::MatrixXd outer_mean{};          ///< (s x C)
  Eigen::MatrixXd inner_mean{};          ///< (q x G)
  Eigen::MatrixXd outer_slope{};         ///< (s p x C) d mean / d beta', by columns
  Eigen::MatrixXd inner_slope{};         ///< (q p x G)
};

/// Random effects with their uncertainty, in the order of the model's clusters and groups; NaN for
/// clusters whose effects were not found.
struct EffectPosteriors {
  Eigen::MatrixXd outer{};  ///< (s x C)
  Eigen::MatrixXd inner{};  ///< (q x G)
  EffectUncertainty outer_uncertainty{};
  EffectUncertainty inner_uncertainty{};
};

/// Finds the effects of each cluster: with held weights for lb, else the modes of the density.
/// \param threads  over blocks; the result does not depend on it
EffectPosteriors find_effects(const NonlinearModel& model,
                              const FittedModel& fit,
                              const EffectPriors& priors,
                              unsigned threads);

/// The uncertainty of effects that are known already: those of a fit, by its own model.
EffectPosteriors describe_effects(const NonlinearModel& model, const FittedModel& fit);

/// The same of a model that has a part of the observations: the rounding of a group's sums depends
/// on where its block begins.
/// \param blocks   first cluster of each block, and the end of the last; other clusters are NaN
/// \param typical  as VarianceData has it
EffectPosteriors describe_effects(const NonlinearModel& model,
                                  const FittedModel& fit,
                                  const std::vector<Eigen::Index>& blocks,
                                  std::vector<double> typical);

/// Priors of groups that were not in the fit.
EffectPriors priors_of_new_groups(const NonlinearModel& model, const FittedModel& fit);

}  // namespace silvafit::fit
