// SPDX-License-Identifier: MIT
// The functions that R calls. All throw exceptions, which init.cpp turns into values.
#pragma once

#include <cpp11/R.hpp>

namespace silvafit::r {

SEXP words_of_messages(SEXP texts);
/// The most similar of some names, or "".
SEXP nearest_name(SEXP name, SEXP names);

/// An analysis by its name (study/analyses.hpp).
/// \param table    a path, columns of a data frame, or NULL
/// \param plots    the table of plots, as `table`
/// \param objects  a list of handles of fits, the handle of a library, or NULL
/// \return a list of tables, rows (from 1), json, fits and notes
SEXP analysis(
    SEXP name, SEXP table, SEXP plots, SEXP objects, SEXP arguments, SEXP folder, SEXP progress);
SEXP setting_list(SEXP parts);
SEXP formula_of_model(SEXP id, SEXP folder);
SEXP read_fit(SEXP json, SEXP file);
SEXP text_of_fit(SEXP handle);
/// The fit with other fixed effects.
SEXP with_estimates(SEXP handle, SEXP estimates);
SEXP read_library(SEXP file, SEXP folder);

}  // namespace silvafit::r
