// SPDX-License-Identifier: MIT
// Parts of the data of pages as JSON; docs/report-data.md describes them.
#pragma once

#include <nlohmann/json.hpp>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/study_record.hpp"
#include "study/formatted_table.hpp"

namespace silvafit::study {

/// The JSON of `silvafit fit --json`, without the computing time, because pages of the
/// same study must not differ. If the uncertainty of the random effects is known, it has
/// `random.eblup_se` instead of matrices for each group: the standard errors of their prediction,
/// sqrt(diag(V + S Var(beta) S')) with the symbols of EffectUncertainty.
nlohmann::ordered_json fit_object(const fit::FittedModel& fit);

/// Predictions for plots left out; null if there are none.
nlohmann::ordered_json left_out_object(const ResponseStudy& result);

/// `repeat` of docs/report-data.md: the fingerprint of the inventory's file (empty for a table in
/// memory), and the versions of the program and its libraries.
/// \throws InputError if the inventory no longer exists
nlohmann::ordered_json report_repeat(const StudyRecord& record);

/// Name and version of the program, the compiler and the numerical libraries that made it.
nlohmann::ordered_json report_versions();

/// As docs/report-data.md describes `tables`.
nlohmann::ordered_json json_of(const FormattedTable& table);

}  // namespace silvafit::study
