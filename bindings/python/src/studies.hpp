// SPDX-License-Identifier: MIT
// The analyses of libstudy: structural units, stands, imputation, studies, libraries, 3D.
#pragma once

#include <pybind11/pybind11.h>

namespace silvafit::python {

/// Structural units, stand tables, imputation, studies, and the class Library.
void add_studies(pybind11::module_& module);
/// The lists of settings.
void add_settings(pybind11::module_& module);
/// Scenes and pages of trees.
void add_trees(pybind11::module_& module);

}  // namespace silvafit::python
