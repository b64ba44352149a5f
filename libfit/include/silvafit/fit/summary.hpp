// SPDX-License-Identifier: MIT
// Text tables of results, as printed by `silvafit fit` and `silvafit compare`. Names from data are
// unchanged, including control characters.
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/bootstrap.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/cross_validation.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/inference_json.hpp"

namespace silvafit::fit {

/// A complete fit: convergence message, estimates, variances, statistics, EBLUPs of up to 40
/// groups, and intervals if it has them.
std::string summary(const FittedModel& fit);

/// Several fits: converged ones by AIC, then failed ones with the reason.
std::string ranking(const std::vector<const FittedModel*>& fits);

std::string summary(const Bootstrap& bootstrap);
/// \param model  its name for the title, or empty
std::string summary(const CrossValidation& result, const std::string& model = {});
/// \param names  of each fit of the comparison
std::string summary(const Comparison& comparison, const FitNames& names);

}  // namespace silvafit::fit
