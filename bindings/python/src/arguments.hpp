// SPDX-License-Identifier: MIT
// Keyword arguments of Python as the fields of option structures.
#pragma once

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>

#include "silvafit/base/error.hpp"

namespace silvafit::python {

namespace py = pybind11;

/// Takes values out of a dictionary by name; what is left at the end is not known.
class Arguments {
 public:
  explicit Arguments(const py::dict& values) : values_(values.attr("copy")()) {}

  /// Leaves the field as it is where the argument is absent or None.
  /// \throws UsageError if the value has another type
  template <class Field>
  void take(const char* name, Field& field) {
    if (!values_.contains(name)) return;
    const py::object value = values_.attr("pop")(name);
    if (value.is_none()) return;
    try {
      field = value.cast<Field>();
    } catch (const py::cast_error&) {
      throw UsageError(
          fmt::format("{} is a value of the wrong type", py::repr(value).cast<std::string>()),
          {.column = name});
    }
  }

  /// \throws UsageError that names an argument that nobody took
  void finish() const {
    for (const auto& item : values_) {
      throw UsageError("unknown argument", {.column = py::str(item.first)});
    }
  }

 private:
  py::dict values_;
};

}  // namespace silvafit::python
