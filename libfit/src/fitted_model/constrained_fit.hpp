// SPDX-License-Identifier: MIT
// Fits with coefficients that are held at a value or kept within bounds.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::fit {

/// A model with some coefficients replaced by numbers: its formula holds them from now on.
/// \param held  values by coefficient
/// \throws UsageError if one is no coefficient, has a random effect, or none is left to estimate
ModelSpecification with_held(const ModelSpecification& specification,
                             const std::map<std::string, double>& held);

/// How a model without constraints is fitted.
using FreeFit = std::function<FitResult(const ModelSpecification&)>;

/// Holds what the options fix, and coefficients at a bound that they would cross, as long as they
/// would. Held coefficients have no standard error; those at a bound count as parameters and are
/// named in the evidence.
/// \throws UsageError as with_held; if a bound excludes everything, or is for no coefficient
FitResult fit_constrained(const ModelSpecification& specification,
                          const FitModelOptions& options,
                          const FreeFit& fit);

}  // namespace silvafit::fit
