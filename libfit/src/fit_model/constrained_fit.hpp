// SPDX-License-Identifier: MIT
// Fits with coefficients that are held at a value or kept within bounds.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// How a model without constraints is fitted.
/// \param nearby  a converged fit to ascend from, described as that of the whole model; null to
///   search for starts
using FreeFit =
    std::function<FitResult(const ModelSpecification& specification, const FittedModel* nearby)>;

/// A fit with what the options fix held, and the coefficients that have bounds within them.
///
/// The result fulfils the conditions of Karush, Kuhn and Tucker: coefficients inside their bounds
/// are where the likelihood is flat, and at a bound it falls, or is flat, into the range. If the
/// fit without bounds is inside them it is the result, and the only fit. Else the bounds are
/// branched over: a fit that left its range at some coefficients is followed by two for each of
/// them, with it held at the lower and at the upper bound; one that did not converge is branched
/// at the coefficients that it ran out of the range with, or at all that are free if none did. A
/// set with several coefficients held is skipped if the fit with one of them less is no better
/// than the best found, unless a fit has shown that such limits do not hold (it had several
/// maxima); the most promising set comes first. Three bounded coefficients make 26 fits at most.
/// If the likelihood increases from a bound into the range, a fit ascends from there. If there must
/// be a maximum on the way that was not found (the likelihood increases from both ends, or is
/// higher there than at the best point), the range is halved where the slope of the profile changes
/// its sign. A single maximum inside the bounds is found; of several, the best of these fits.
///
/// Held coefficients have no standard error. Those at a bound count as parameters and are named in
/// the evidence. A result has not converged if no point fulfils the conditions, or a fit that did
/// not converge was within the bounds and better.
/// \throws UsageError as with_held; if a bound excludes everything, or is for no coefficient
/// Source: Nocedal and Wright 2006, Numerical Optimization, theorem 12.1; Land and Doig 1960,
///   Econometrica 28, 497-520 (branch and bound).
FitResult fit_constrained(const ModelSpecification& specification,
                          const data::Table& table,
                          const FitModelOptions& options,
                          const FreeFit& fit);

}  // namespace silvafit::fit
