// SPDX-License-Identifier: MIT
// Findings of a search over starting points.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/base/constants.hpp"
#include "silvafit/fit/mixed_effects.hpp"

namespace silvafit::fit {

/// The origin of optima from the user's start values.
inline constexpr std::string_view kStartValues = "start values";
/// The origin of optima from further starts that the user requested.
inline constexpr std::string_view kSpreadStart = "spread start";

/// A nested model with a higher likelihood.
struct ContainedModel {
  std::string text{};  ///< "without the random effect of a"
  double log_likelihood = 0.0;
  double rank = 0.0;  ///< the likelihood by which fits are compared: marginal, unless it is that
};

/// The nested model that is higher than a fit by the likelihood that ranks fits, the simplest of
/// the equally high; none if no nested model is higher.
std::optional<ContainedModel> higher_than(double rank,
                                          const std::vector<ContainedModel>& contained);

/// Findings of a search over starting points besides the fit.
struct SearchEvidence {
  std::optional<Method> method{};  ///< of a marginal likelihood
  std::optional<ContainedModel> contained{};
  /// Of a fit by Lindstrom and Bates' method: the marginal log-likelihood at its estimates, the
  /// highest one, and of which method; NaN or -infinity where they are not known.
  double marginal_here = kNaN;
  double marginal_maximum = -kInfinity;
  Method marginal = Method::kLaplace;
  /// Whether the fit's own log-likelihood is a restricted one, which changes with the units of the
  /// covariates and is not comparable with a marginal one.
  bool is_restricted = false;
  /// Of a marginal likelihood with all second derivatives: the maximum of the first-order one, if
  /// Laplace's may not be valid there; else NaN.
  double first_order_maximum = kNaN;
  /// Of a marginal likelihood: the log-likelihood of a point from which a search increased without
  /// bound, if it is the highest; else NaN.
  double unfinished = kNaN;
};

/// Adds the findings of the search to those of the fit. A fit of a marginal
/// likelihood below that of a nested model has not converged; one by Lindstrom and Bates' method is
/// at a fixed point, and the difference is a doubt unless it is as large as for a useless
/// linearization. Nor has a fit converged whose linearized likelihood is far from the marginal one;
/// if they differ by more than 2 units, the linearization is reported as doubtful.
void judge_search(const ModelSpecification& specification,
                  const SearchEvidence& evidence,
                  MixedEffectsFit& fit);

/// The likelihood with more points of quadrature than a fit has, or would have.
struct QuadratureCheck {
  std::vector<std::string> kinks{};  ///< random coefficients in which the mean has kinks
  /// Log-likelihood at the estimates with so many points per random effect; NaN if it is unknown.
  double log_likelihood = kNaN;
  int points = 0;
};

/// Adds what quadrature says about a fit by it, and about one with kinks, where the other methods
/// take the mean for smooth in the random effects.
/// \param evidence  of the search that has led to the fit
void judge_quadrature(MixedEffectsFit& fit,
                      const QuadratureCheck& check,
                      const SearchEvidence& evidence);

}  // namespace silvafit::fit
