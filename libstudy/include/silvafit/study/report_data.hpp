// SPDX-License-Identifier: MIT
// The data of a study's report page.
#pragma once

#include <string>

#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/study_record.hpp"

namespace silvafit::study {

/// The data of the report page, as docs/report-data.md describes them.
std::string report_data(const StudyRecord& record, const Catalogue& catalogue);

}  // namespace silvafit::study
