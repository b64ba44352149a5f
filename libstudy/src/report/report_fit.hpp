// SPDX-License-Identifier: MIT
// A fit in the form that all pages read.
#pragma once

#include <nlohmann/json.hpp>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::study {

/// What `silvafit fit --json` prints of a fit, without the time that it took, which would make two
/// pages of the same study differ. Where the uncertainty of the random effects is known, it has
/// `random.eblup_se` instead of matrices for each group: the standard errors of their prediction,
/// sqrt(diag(V + S Var(beta) S')) with the symbols of EffectUncertainty.
nlohmann::ordered_json fit_object(const fit::FittedModel& fit);

}  // namespace silvafit::study
