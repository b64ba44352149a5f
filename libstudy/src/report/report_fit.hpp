// SPDX-License-Identifier: MIT
// A fit as JSON for all pages.
#pragma once

#include <nlohmann/json.hpp>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::study {

/// The JSON of `silvafit fit --json`, without the computing time, because pages of the
/// same study must not differ. If the uncertainty of the random effects is known, it has
/// `random.eblup_se` instead of matrices for each group: the standard errors of their prediction,
/// sqrt(diag(V + S Var(beta) S')) with the symbols of EffectUncertainty.
nlohmann::ordered_json fit_object(const fit::FittedModel& fit);

}  // namespace silvafit::study
