// SPDX-License-Identifier: MIT
// Labels of new trees, such as plots, strata and species, compared with those of a fit.
#pragma once

#include <string>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::study {

/// Spells the labels of a column as in a fit: "07" is the group that a fit stores as "7",
/// if it was read as a number.
void unify_spelling(const std::string& column,
                    const std::vector<std::string>& known_labels,
                    data::Table& table);

/// Spells strata, and labels that the model compares with text, as in the fit.
void unify_spelling(const fit::FittedModel& fit, data::Table& table);

/// (N) whether the label of a row is not in the fit; false for missing labels.
std::vector<bool> has_unknown_label(const fit::ColumnLevels& levels, const data::Table& table);

}  // namespace silvafit::study
