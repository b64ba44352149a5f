// SPDX-License-Identifier: MIT
// Labels of new trees, such as plots, strata and species, beside those that a fit has seen.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::study {

/// Spells the labels of a column as they are known: "07" is the group that a fit knows as "7",
/// where that was read as a number.
void unify_spelling(const std::string& column,
                    const std::vector<std::string>& known_labels,
                    data::Table& table);

/// Strata, and what the model compares with text, as the fit spells them.
void unify_spelling(const fit::FittedModel& fit, data::Table& table);

/// (N) whether a row has a label that the fit has not seen; a missing one is none.
std::vector<bool> has_unknown_label(const fit::ColumnLevels& levels, const data::Table& table);

}  // namespace silvafit::study
