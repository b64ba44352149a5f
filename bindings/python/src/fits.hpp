// SPDX-License-Identifier: MIT
// Fits: their computation, content and derived results.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>

#include "silvafit/fit/fitted_model.hpp"

namespace silvafit::python {

using FitPointer = std::shared_ptr<fit::FittedModel>;

/// A fit for Python, which nobody changes any more.
inline FitPointer share(fit::FittedModel fit) {
  return std::make_shared<fit::FittedModel>(std::move(fit));
}

/// The class Fit with its values and JSON, the catalogue, and the columns that texts read.
void add_fits(pybind11::module_& module);
/// The analyses of libstudy by their names, and the class Library.
void add_analyses(pybind11::module_& module);
/// The lists of settings.
void add_settings(pybind11::module_& module);

}  // namespace silvafit::python
