// SPDX-License-Identifier: MIT
// The functions that R calls. All throw exceptions, which init.cpp turns into values.
#pragma once

#include <cpp11/R.hpp>

namespace silvafit::r {

SEXP words_of_messages(SEXP texts);

// Fits
SEXP fit_model(SEXP columns, SEXP model, SEXP option_list);
SEXP formula_of_model(SEXP id, SEXP folder);
SEXP read_fit(SEXP json, SEXP file);
SEXP text_of_fit(SEXP handle);
/// The fit with other fixed effects.
SEXP with_estimates(SEXP handle, SEXP estimates);
/// The complete rows of a table: responses, fitted values and residual standard deviations.
SEXP rows_of_fit(SEXP handle, SEXP columns);
SEXP predict_fit(SEXP handle, SEXP columns, SEXP settings);
SEXP intervals_of_fit(SEXP handle, SEXP columns, SEXP settings);
SEXP compare_fits(SEXP handles);
SEXP simulate_fit(SEXP handle, SEXP columns, SEXP replicates, SEXP seed);
SEXP bootstrap_fit(SEXP handle, SEXP columns, SEXP settings);
SEXP cross_validate_fit(SEXP handle, SEXP columns, SEXP settings);

// Stands
SEXP setting_list(SEXP parts);
SEXP structural_units(SEXP source, SEXP settings);
SEXP stand_summary(SEXP source, SEXP settings);
SEXP stand_growth(SEXP source, SEXP settings);
SEXP impute_table(SEXP source, SEXP settings);
SEXP study_of(SEXP source, SEXP settings);
SEXP read_library(SEXP file, SEXP models);
SEXP predict_library(SEXP library, SEXP source, SEXP settings);
SEXP grow_trees(SEXP source, SEXP settings);
SEXP view_page(SEXP source, SEXP settings);

}  // namespace silvafit::r
