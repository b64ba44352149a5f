// SPDX-License-Identifier: MIT
// Least-squares fits to single groups, as by nlsList of R's nlme.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// Fits to single groups that begin at the same parameters.
struct GroupFits {
  MatrixXd own{};          ///< (K x G) parameters; NaN for groups without a fit
  VectorXd medians{};      ///< (K)
  std::size_t fitted = 0;  ///< number of groups with a fit
  double sum_of_squares = 0.0;
  double residual_sd = 0.0;
};

/// Fits the groups with enough observations, at most forty of them, evenly chosen, from the pooled
/// coefficients. Where groups differ much, curves of quite different shapes fit all groups together
/// equally well, but not each group. Therefore minima are also searched in the largest groups
/// alone, and all groups are fitted from those of three groups that are lower, and from exchanged
/// medians. If there are lower ones and nonlinear parameters have random effects, the last of the
/// fits has the others held at those of one group, so that groups with few observations have a fit,
/// too, and places that vary more than a peak is wide are found.
///
/// \param constants  the model without covariates
/// \param pooled     (p) coefficients of the fit to all groups together
/// \returns none if fewer than three groups have a fit
std::vector<GroupFits> fit_single_groups(const NonlinearModel& model,
                                         const NonlinearModel& constants,
                                         const VectorXd& pooled);

/// A start with the deviations of the groups' own parameters as random effects, as nlme starts from
/// an nlsList; none with two groupings or random effects of a covariate's coefficient.
/// \param estimate  (p) at the medians
std::optional<MixedEffectsFit> start_with_effects(const NonlinearModel& model,
                                                  const VectorXd& estimate,
                                                  const GroupFits& groups);

}  // namespace silvafit::fit
