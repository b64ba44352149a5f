// SPDX-License-Identifier: MIT
// Fits with coefficients that are held at a value or kept within bounds.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "fit_model/bounded_search.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// How a model without constraints is fitted.
/// \param nearby  a converged fit to ascend from, described as that of the whole model; null to
///   search for starts
using FreeFit =
    std::function<FitResult(const ModelSpecification& specification, const FittedModel* nearby)>;

/// Fits of the whole model with further coefficients held. The arguments must outlive the result.
/// \param fixed  values of coefficients that all of these fits hold
HeldFit held_fit_of(const ModelSpecification& specification,
                    const std::map<std::string, double>& fixed,
                    const FreeFit& fit);

/// A fit with the coefficients of `fixed` held, and those of `bounds` within their bounds.
///
/// The result fulfils the conditions of Karush, Kuhn and Tucker: the likelihood is flat at
/// coefficients inside their bounds, and at a bound it decreases, or is flat, into the range. If
/// the fit without bounds is inside them, it is the result and the only fit. Otherwise this is a
/// branch and bound: a fit with some coefficients outside their range is followed by two fits for
/// each of them, held at the lower and at the upper bound. A fit that did not converge branches at
/// the coefficients that left their range, or at all free ones if none did. A set with several
/// coefficients held is skipped if the fit with one of them less is no better than the best found,
/// unless a fit has shown that such limits do not hold (because of several maxima). The most
/// promising set comes first. Three bounded coefficients need at most 26 fits. If the likelihood
/// increases from a bound into the range, a fit ascends from there. If there must be a maximum
/// between that was not found (the likelihood increases from both ends, or is higher there than at
/// the best point), the range is bisected by the sign of the slope of the profile. Optima within
/// the bounds that the search of a fit outside of them knows, and those of the same mean with
/// exchanged coefficients, compete with these fits. A single maximum inside
/// the bounds is found; of several, the best of these fits.
///
/// Values and bounds of a coefficient with random effects are for its fixed effect.
///
/// Held coefficients have no standard error. Those at a bound count as parameters and are named in
/// the evidence. A result has not converged if no point fulfils the conditions, or a fit that did
/// not converge was within the bounds and better.
/// \throws UsageError as with_held; if a bound excludes everything, or is for no coefficient
/// Source: Nocedal and Wright 2006, Numerical Optimization, theorem 12.1; Land and Doig 1960,
///   Econometrica 28, 497-520 (branch and bound).
/// \param inside  its `held` includes the coefficients of `fixed`
FitResult fit_constrained(const ModelSpecification& specification,
                          const data::Table& table,
                          const FitModelOptions& options,
                          const FreeFit& fit,
                          const InsideFit& inside);

}  // namespace silvafit::fit
