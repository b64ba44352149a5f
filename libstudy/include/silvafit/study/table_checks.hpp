// SPDX-License-Identifier: MIT
// Checks of the data of a command: rows, columns, and whether a model is defined for
// them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "silvafit/data/table.hpp"
#include "silvafit/fit/fitted_model.hpp"
#include "silvafit/fit/model_texts.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/catalogue.hpp"

namespace silvafit::study {

/// Adds columns under names of the user's choice. Structural indices that a source names and the
/// table lacks are computed by add_structure_columns: `C=C`.
/// \param columns  a source is a column or an expression of columns
/// \param options  of structural indices
/// \return         notes on which indices were computed, and how
/// \throws as data::checked_values
std::vector<std::string> add_columns(const std::vector<stand::ColumnMapping>& columns,
                                     data::Table& table,
                                     const stand::StructuralUnitOptions& options = {});

/// Makes sure that columns which an expression reads as numbers hold numbers.
/// \param variables  of an expression; those that compare a column with text may have text
/// \throws InputError at the first value that is no number, or if there is no such column
void require_numbers(const data::Table& table, const std::vector<std::string>& variables);

/// The end of a message on missing columns: where structural indices are found, ". The indices of a
/// study are in ..."; empty if none of them is a structural index.
std::string origin_of_missing(const std::vector<std::string>& columns, const data::Table& table);

/// Whether a value can have been measured, as require_possible() says.
/// \param h_m  height of the tree; NaN if it is not known
bool is_possible_value(const std::string& response, double value, double h_m);

/// Checks that measured values are possible: h above breast height, 1.3 m, hcb not below the
/// ground and below h, cw above 0. Other responses are not checked.
/// \throws InputError at a value that is no number; DomainError at the first that cannot be
///   measured, such as 0 or -9999 for a missing one
void require_possible(const std::string& response, const data::Table& table);

/// The same of values below 0, which no size has in a table with dbh, for models of the user.
void require_not_negative(const std::string& response, const data::Table& table);

/// Makes values missing that require_possible() would refuse.
/// \return a note with their number and the first; empty if there are none
std::string leave_out_impossible(const std::string& response, data::Table& table);
/// The same of require_not_negative().
std::string leave_out_negative(const std::string& response, data::Table& table);

/// Checks that a model of the catalogue is defined for all rows, except missing values.
/// \throws InputError if a column is not there or holds text; DomainError at the first value
///   outside the model's domain
void require_domain(const BaseModel& model, const data::Table& table);

/// Makes texts and options those of a model of the catalogue: its formula, and start values by its
/// rules.
/// \throws as require_domain and require_possible; InputError if rows are too few for start values
void use_base_model(const BaseModel& model,
                    const data::Table& table,
                    fit::ModelTexts& texts,
                    fit::FitModelOptions& options);

/// The same as require_domain for predictions: the conditions on the covariates only.
void require_domain_of_covariates(const BaseModel& model, const data::Table& table);

/// The model of the catalogue that a fit is of; null if it is of none, or there is no catalogue.
const BaseModel* base_model_of(const fit::FittedModel& fit, const Catalogue* catalogue);

}  // namespace silvafit::study
