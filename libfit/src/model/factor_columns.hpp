// SPDX-License-Identifier: MIT
// The columns of a sub-model's terms, factors coded by R's rules (contr.treatment).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "model/sub_model_terms.hpp"
#include "silvafit/data/table.hpp"
#include "silvafit/fit/model_specification.hpp"

namespace silvafit::fit {

/// Whether a sub-model has a column of text, or factor(column).
bool has_factor(const TermFormula& formula, const data::Table& table);

/// Rows without missing values in the given columns.
std::vector<bool> complete_rows(const std::vector<std::string>& columns, const data::Table& table);

/// The model with a covariate for each column that R's model.matrix() has for these terms.
///
/// A column of text, and factor(column), is a factor. It has a column for each level except the
/// first in its first term beside an intercept, and if the rest of its term is in the model without
/// it; else one for each level. The columns of a level are comparisons: `(species == "SM")`.
/// \param text      of the sub-model, for messages
/// \param complete  rows whose levels are used; not read without factors
/// \param factors   gets the columns that are factors
/// \throws FormulaError if columns would be redundant; InputError if a factor has one level, too
///   many or looks like misspelt numbers, or if a product of levels has no row
ParameterModel expanded(const TermFormula& formula,
                        std::string_view text,
                        const data::Table& table,
                        const std::vector<bool>& complete,
                        std::vector<std::string>& factors);

/// The model of numeric terms, without data.
/// \throws FormulaError if there is a factor()
ParameterModel expanded(const TermFormula& formula, std::string_view text);

}  // namespace silvafit::fit
