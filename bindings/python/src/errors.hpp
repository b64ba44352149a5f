// SPDX-License-Identifier: MIT
// Errors of the libraries as the exceptions of silvafit/_errors.py.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <string_view>

namespace silvafit::python {

void add_errors(pybind11::module_& module);

/// A message of the libraries with keyword arguments in place of settings.
std::string in_words_of_python(std::string_view message);

}  // namespace silvafit::python
