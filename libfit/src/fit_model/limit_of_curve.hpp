// SPDX-License-Identifier: MIT
// Fits whose likelihood has no maximum because coefficients approach a limit of the curve.
#pragma once

#include <map>
#include <string>

#include "fit_model/constrained_fit.hpp"
#include "silvafit/fit/nonlinear_model.hpp"

namespace silvafit::fit {

using CoefficientBounds = std::map<std::string, Bounds>;

/// Marks a converged fit as one without a maximum if its curve is only a limit of the formula.
///
/// a*(1 - exp(-k*x))^p approaches the power b*x^p for large a and small k. If the data show only
/// this part, the likelihood increases towards the limit ever more slowly, until a search cannot
/// resolve the gain, and differences of gradients give arbitrary standard errors there. Candidates
/// are coefficients with a standard error, by the expected information at the population's curve,
/// of more than ten times their size (undetermined()). The one that is determined least is held up
/// to a thousand times larger and smaller. The fit has no maximum if the highest likelihood with it
/// held, far towards one side, is not lower than that of the fit.
/// \param fit     of the whole model with some coefficients held
/// \param bounds  within which the limit has to be; one side of a range may be open
/// Cost: without candidates one Jacobian; otherwise up to eight fits.
void mark_limit(const NonlinearModel& model,
                const HeldFit& fit,
                FitResult& result,
                const CoefficientBounds& bounds = {});

/// Start values on the other side of infinity: the coefficients that grow without bound with the
/// opposite sign. V*x/(K + x) is a straight line at both ends, and the maximum for a curve that
/// bends upwards lies at negative V and K. Since a search may end anywhere on the way to infinity,
/// they are the smallest, by powers of ten, with which the population's curve is within four
/// standard errors of the closest. Empty if the fit has no such coefficients.
std::map<std::string, double> start_beyond_infinity(const NonlinearModel& model,
                                                    const FittedModel& fit);

}  // namespace silvafit::fit
