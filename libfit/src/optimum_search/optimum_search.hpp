// SPDX-License-Identifier: MIT
// The search for the highest maximum of a mixed model's likelihood.
#pragma once

#include <optional>

#include "optimum_search/chosen_optimum.hpp"
#include "silvafit/fit/least_squares.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The best of the fits from all starting points.
///
/// Lindstrom and Bates' method runs from each starting point. Its fixed points are ranked by their
/// marginal likelihood, because its own is that of a different linear model at each. The marginal
/// likelihood is maximized from the best ones, and its maximum is a start for a further fixed
/// point. Then each random effect is omitted in turn: the fit of a model must not have a lower
/// likelihood than that of a nested model. docs/local-maxima.md describes the search.
/// \param pooled       the least-squares fit, with its other minima
///   effects) without one
/// \param options      their starts are the user's
/// \param wishes       of which start values, bounds and the number of further starts are used
MixedEffectsFit search_optimum(const NonlinearModel& model,
                               const LeastSquaresFit& pooled,
                               Method method,
                               const MixedEffectsOptions& options,
                               const FitModelOptions& wishes);

}  // namespace silvafit::fit
