// SPDX-License-Identifier: MIT
// The optimum that is reported: the best within the user's bounds, with the roles of the start.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "optimum_search/candidate_fits.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// What the user wants of the coefficients, by name.
struct CoefficientWishes {
  std::map<std::string, double> start{};
  std::map<std::string, Bounds> bounds{};
};

/// The converged fit to report; the best one without wishes.
///
/// Fits outside the bounds are left out if one is inside. Of the others, fits of the same curves
/// are the same description of the data with exchanged roles, such as the two asymptotes of a
/// logistic curve, or the rates of absorption and elimination. The start values say which role
/// each coefficient has: the nearest such fit is reported, unless the best one has a log-likelihood
/// that is higher by more than kVeryStrong.
/// \param best  one of the candidates
const Candidate& chosen_optimum(const std::vector<std::string>& names,
                                const std::vector<Candidate>& candidates,
                                const Candidate& best,
                                const CoefficientWishes& wishes);

}  // namespace silvafit::fit
