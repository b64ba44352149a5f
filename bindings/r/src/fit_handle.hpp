// SPDX-License-Identifier: MIT
// Fits behind handles.
#pragma once

#include <cpp11/R.hpp>
#include <cpp11/sexp.hpp>

#include "silvafit/fit/fit_json.hpp"

namespace silvafit::r {

/// A fit in R: `handle`, and `fit`, the values that R shows.
cpp11::sexp list_of_fit(fit::FittedModel fit);

/// The fit of a handle, which lives as long as the handle.
/// \throws UsageError if the value is no handle
const fit::FittedModel& fit_of(SEXP handle);

}  // namespace silvafit::r
