// SPDX-License-Identifier: MIT
// Errors of the libraries as the exceptions of silvafit/_errors.py.
#pragma once

#include <pybind11/pybind11.h>

namespace silvafit::python {

void add_errors(pybind11::module_& module);

}  // namespace silvafit::python
