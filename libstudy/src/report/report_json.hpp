// SPDX-License-Identifier: MIT
// Parts of the data of pages as JSON; docs/report-data.md describes them.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

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

/// Of the bytes of the inventory's file; empty for a table in memory, a sheet of a workbook or a
/// layer of a database.
std::string inventory_fingerprint(const StudyRecord& record);

/// `repeat` of docs/report-data.md: inventory_fingerprint(), and the versions of the program and
/// its libraries.
nlohmann::ordered_json report_repeat(const StudyRecord& record);

/// Name and version of the program, the compiler and the numerical libraries that made it.
nlohmann::ordered_json report_versions();

/// As docs/report-data.md describes `tables`.
nlohmann::ordered_json json_of(const FormattedTable& table);

/// Windows, stems, crowns and structural units, as docs/report-data.md describes them. Empty
/// without positions, or if there are so many trees that the page would be slow.
std::optional<nlohmann::ordered_json> report_map(const StudyRecord& record);

/// The member `stand` of the report data (docs/report-data.md); none without areas.
std::optional<nlohmann::ordered_json> district_object(const StudyRecord& record);

/// A curve of dbh as a formula of a spreadsheet, with its coefficients as numbers:
/// `=1.3+A2^2/(0.18852*A2+1.524)^2`. A minus at the beginning of a term is written as 0-, because
/// spreadsheets compute -x^2 as (-x)^2. Empty if the model reads further columns.
/// \param cell  with the diameter
std::string spreadsheet_formula(const fit::FittedModel& fit, const std::string& cell);

}  // namespace silvafit::study
