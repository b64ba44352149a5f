// SPDX-License-Identifier: MIT
// silvafit._core: the libraries for the Python package, which gives them their shape.
#include <pybind11/pybind11.h>

#include "errors.hpp"
#include "fits.hpp"
#include "tables.hpp"

PYBIND11_MODULE(_core, module) {
  using namespace silvafit::python;
  module.attr("__version__") = SILVAFIT_VERSION;
  add_errors(module);
  add_tables(module);
  add_fits(module);
  add_settings(module);
  add_analyses(module);
}
