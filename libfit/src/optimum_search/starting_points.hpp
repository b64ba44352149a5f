// SPDX-License-Identifier: MIT
// Coefficients from which the search of a mixed model begins.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "silvafit/fit/least_squares.hpp"
#include "silvafit/fit/matrices.hpp"
#include "silvafit/fit/mixed_effects.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

/// The origins of the pooled fit and of pooled fits that are nearly as good.
inline constexpr std::string_view kPooledFit = "least squares";
inline constexpr std::string_view kOtherMinimum = "other least-squares minimum";
/// The origin of medians of least-squares fits to single groups.
inline constexpr std::string_view kGroupMedians = "medians of single groups";

struct StartingPoint {
  VectorXd coefficients{};  ///< (p)
  std::string origin{};     ///< "least squares", "start values", ... for reports
  std::optional<MixedEffectsFit> with_effects{};  ///< the same with random effects, if known
};

/// Distinct points that may lead to different maxima of the likelihood, the most promising first:
/// the pooled least-squares fit; coefficients with exchanged terms, and those with a similar fit to
/// the pooled data; medians of least-squares fits to single groups; the fit of a linear form of the
/// formula (h = d^2/(a + b d) is linear in d^2/h); exchanged terms of all of these; and spread
/// points.
/// \param pooled  the least-squares fit, with its other minima
/// \param spread  number of further points, spread around the others
std::vector<StartingPoint> starting_points(const NonlinearModel& model,
                                           const LeastSquaresFit& pooled,
                                           int spread = 0);

}  // namespace silvafit::fit
