// SPDX-License-Identifier: MIT
// Fits as tables for people.
#pragma once

#include <vector>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::cli {

/// One fit in full: the verdict first, then estimates, variances and statistics.
void print_fit(const fit::FittedModel& fit);

/// Several fits, those that converged by AIC, those that failed at the end with the reason.
void print_ranking(const std::vector<const fit::FittedModel*>& fits);

}  // namespace silvafit::cli
