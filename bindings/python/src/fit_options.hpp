// SPDX-License-Identifier: MIT
// The keyword arguments of sf.fit() as options of the library.
#pragma once

#include <pybind11/pybind11.h>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::python {

/// \throws UsageError for an unknown name or method, or a value of the wrong type
fit::FitModelOptions fit_options(const pybind11::dict& keywords);

}  // namespace silvafit::python
