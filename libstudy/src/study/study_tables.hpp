// SPDX-License-Identifier: MIT
// The tables of a study.
#pragma once

#include <vector>

#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/study_record.hpp"
#include "study/formatted_table.hpp"

namespace silvafit::study {

/// All tables in the order of the levels: species (importance values), candidates, covariates,
/// random_effects, variance_functions, estimates, variance_components, statistics, gains,
/// level_tests.
std::vector<FormattedTable> study_tables(const StudyRecord& record, const Catalogue& catalogue);

}  // namespace silvafit::study
