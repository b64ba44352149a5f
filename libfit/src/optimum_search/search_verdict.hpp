// SPDX-License-Identifier: MIT
// What a search over starting points has found, and what it means for the verdict on a fit.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The origin of optima that the user's start values lead to.
inline constexpr std::string_view kStartValues = "start values";
/// The origin of optima that further starts, which the user has asked for, lead to.
inline constexpr std::string_view kSpreadStart = "spread start";

/// A model that the fitted one contains, with a higher likelihood.
struct ContainedModel {
  std::string text{};  ///< "without the random effect of a"
  double log_likelihood = 0.0;
  double rank = 0.0;  ///< the likelihood by which fits are compared: marginal, unless it is that
};

/// The model that a fit is below most, by the likelihood that ranks fits; nothing if there is
/// none.
std::optional<ContainedModel> higher_than(double rank,
                                          const std::vector<ContainedModel>& contained);

/// What a search over starting points has found besides the fit.
struct SearchEvidence {
  std::optional<Integration> method{};  ///< of a marginal likelihood
  std::optional<ContainedModel> contained{};
  /// Of a fit by Lindstrom and Bates' method: the marginal log-likelihood at its estimates, the
  /// highest one, and of which method; NaN or -infinity where they are not known.
  double marginal_here = std::numeric_limits<double>::quiet_NaN();
  double marginal_maximum = -std::numeric_limits<double>::infinity();
  Integration marginal = Integration::kLaplace;
  /// Whether the fit's own log-likelihood is a restricted one, which changes with the units of the
  /// covariates and does not compare with a marginal one.
  bool is_restricted = false;
  /// Of a marginal likelihood with all second derivatives: the maximum of the first-order one,
  /// where that lies at a point at which Laplace's may not hold; else NaN.
  double first_order_maximum = std::numeric_limits<double>::quiet_NaN();
  /// Of a marginal likelihood: the log-likelihood of a point from which a search went on rising
  /// without an end, if it is the highest; else NaN.
  double unfinished = std::numeric_limits<double>::quiet_NaN();
};

/// Puts into the verdict what the search has found. A fit below a model that it contains has not
/// converged, nor has one whose linearized likelihood has nothing to do with the marginal one;
/// where they differ by more than 2 units, the linearization is doubtful.
void judge_search(MixedEffectsFit& fit, const SearchEvidence& evidence);

}  // namespace silvafit::fit
