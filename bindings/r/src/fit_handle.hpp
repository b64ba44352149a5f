// SPDX-License-Identifier: MIT
// Fits that R holds by an external pointer.
#pragma once

#include <cpp11/R.hpp>
#include <cpp11/sexp.hpp>
#include <string>

#include "silvafit/fit/fit_json.hpp"

namespace silvafit::r {

/// An external pointer to a fit. It protects the text of the fit, which saveRDS() writes.
cpp11::sexp handle_of(fit::FittedModel fit, const std::string& json);

/// A fit in R: `handle`, and `fit`, the values that R shows.
cpp11::sexp list_of_fit(fit::FittedModel fit);

/// The fit of a handle, which is parsed again after readRDS(). It lives as long as the handle.
/// \throws UsageError if the value is no handle
const fit::FittedModel& fit_of(SEXP handle);

/// The text of the fit.
SEXP json_of(SEXP handle);

}  // namespace silvafit::r
