// SPDX-License-Identifier: MIT
// The species of an inventory with their importance values, in all and by layer.
#pragma once

#include "silvafit/study/study_record.hpp"
#include "study/formatted_table.hpp"

namespace silvafit::study {

/// Table 1 of Wang and others 2023: density, importance values of each layer and of all trees,
/// sizes (means and standard deviations), basal area and dominant height, by falling importance.
/// Areas, and values per hectare, need windows; layers need heights.
FormattedTable species_importance_table(const StudyRecord& record);

}  // namespace silvafit::study
