// SPDX-License-Identifier: MIT
// The random effects of a fit, the only place that reads how a fit stores them.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::python {

/// One dictionary for each grouping, the coarser first: `columns` of the groups, `names` of the
/// effects, `form` and `covariance`, `labels` (a list for each column), `effects` (groups x
/// effects) and their conditional standard errors `se`, None if they are not known.
pybind11::list random_terms(const fit::FittedModel& fit);

/// The random effects as text, `a + b | plot`; empty if there are none.
std::string random_text(const fit::FittedModel& fit);

}  // namespace silvafit::python
