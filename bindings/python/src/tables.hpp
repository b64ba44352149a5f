// SPDX-License-Identifier: MIT
// Tables of the libraries from and to numpy arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>

#include "silvafit/data/csv.hpp"
#include "silvafit/data/table.hpp"

namespace silvafit::python {

namespace py = pybind11;

using TablePointer = std::shared_ptr<data::Table>;

/// A table for Python, which nobody changes any more.
inline TablePointer share(data::Table table) {
  return std::make_shared<data::Table>(std::move(table));
}

/// A path (text) or a Table.
data::TableSource source_of(const py::object& trees);

void add_tables(py::module_& module);

}  // namespace silvafit::python
