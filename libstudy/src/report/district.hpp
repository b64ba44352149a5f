// SPDX-License-Identifier: MIT
// The part of the report for foresters: stand table, diameters and height curves.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// The member `stand` of the report data (docs/report-data.md); none without areas.
std::optional<nlohmann::ordered_json> district_object(const StudyRecord& record);

/// A curve of dbh as a formula of a spreadsheet, with its coefficients as numbers:
/// `=1.3+A2^2/(0.18852*A2+1.524)^2`. A minus at the beginning of a term is written as 0-, because
/// spreadsheets compute -x^2 as (-x)^2. Empty if the model reads further columns.
/// \param cell  with the diameter
std::string spreadsheet_formula(const fit::FittedModel& fit, const std::string& cell);

}  // namespace silvafit::study
