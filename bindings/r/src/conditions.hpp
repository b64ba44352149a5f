// SPDX-License-Identifier: MIT
// Errors of silvafit as values, which an R function turns into conditions with classes.
#pragma once

#include <cpp11/R.hpp>
#include <cpp11/declarations.hpp>
#include <exception>
#include <functional>

namespace silvafit::r {

/// The value of a function; or, if it throws an exception, a list of class silvafit_failure with
/// the kind of the error, its text and its place.
SEXP guarded(const std::function<SEXP()>& work);

}  // namespace silvafit::r
