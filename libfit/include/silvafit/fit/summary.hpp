// SPDX-License-Identifier: MIT
// Results as tables for people, as `silvafit fit` and `silvafit compare` print them. Names that
// come from data are in them as they are, with any control characters.
#pragma once

#include <string>
#include <vector>

#include "silvafit/fit/bootstrap.hpp"
#include "silvafit/fit/comparison.hpp"
#include "silvafit/fit/cross_validation.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/inference_json.hpp"

namespace silvafit::fit {

/// One fit in full: the verdict first, then estimates, variances, statistics, EBLUPs of up to 40
/// groups, and intervals if it has them.
std::string summary(const FittedModel& fit);

/// Several fits, those that converged by AIC, those that failed at the end with the reason.
std::string ranking(const std::vector<const FittedModel*>& fits);

std::string summary(const Bootstrap& bootstrap);
/// \param model  its name for the title, or empty
std::string summary(const CrossValidation& result, const std::string& model = {});
/// \param names  of each fit of the comparison
std::string summary(const Comparison& comparison, const FitNames& names);

}  // namespace silvafit::fit
