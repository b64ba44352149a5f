// SPDX-License-Identifier: MIT
// The optimum that is reported: the best within the user's bounds, with the roles of the start.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "optimum_search/candidate_fits.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// Whether bounded coefficients are within their bounds.
bool is_inside(const std::vector<std::string>& names,
               const VectorXd& estimate,
               const std::map<std::string, Bounds>& bounds);

/// The converged fit to report; the best one if the user gives no start
/// values or bounds.
///
/// Fits outside the bounds are left out if one is inside. Of the others, fits of the same curves
/// are the same description of the data with exchanged roles, such as the two asymptotes of a
/// logistic curve, or the rates of absorption and elimination. The start values say which role
/// each coefficient has: the nearest such fit is reported, unless the best one has a log-likelihood
/// that is higher by more than kVeryStrong.
/// \param best    one of the candidates
/// \param wishes  of which start values and bounds are used
const Candidate& chosen_optimum(const std::vector<std::string>& names,
                                const std::vector<Candidate>& candidates,
                                const Candidate& best,
                                const FitModelOptions& wishes);

/// The fit, or the one of the same curves with exchanged coefficients that is within the bounds,
/// and of these the nearest to the start values.
///
/// Where an exchange leaves the curve of every group unchanged, as that of the rates of absorption
/// and elimination if only the clearance varies, both fits are one maximum to a search.
/// \param wishes  of which start values and bounds are used
/// \returns an exchanged fit has no degrees of freedom and message yet
MixedEffectsFit with_wished_roles(const NonlinearModel& model,
                                  const MixedEffectsFit& fit,
                                  Method method,
                                  const MixedEffectsOptions& options,
                                  const FitModelOptions& wishes);

}  // namespace silvafit::fit
