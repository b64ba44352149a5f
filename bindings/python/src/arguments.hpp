// SPDX-License-Identifier: MIT
// Keyword arguments of Python as the fields of option structures.
#pragma once

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <concepts>
#include <string>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/near_names.hpp"

namespace silvafit::python {

namespace py = pybind11;

/// Removes values from a dictionary by name; the rest at the end are unknown arguments.
class Arguments {
 public:
  explicit Arguments(const py::dict& values) : values_(values.attr("copy")()) {}

  /// Does not change the field if the argument is absent or None.
  /// \return whether there is a value
  /// \throws UsageError if it has another type
  template <class Field>
  bool take(const char* name, Field& field) {
    py::object value = take(name);
    if (value.is_none()) return false;
    try {
      // True is no number, and a Series of pandas has names, too.
      if (std::integral<Field> && !std::same_as<Field, bool> && py::isinstance<py::bool_>(value)) {
        throw py::cast_error();
      }
      if (!py::isinstance<py::dict>(value) && py::hasattr(value, "keys")) value = py::dict(value);
      field = value.cast<Field>();
      return true;
    } catch (const py::cast_error&) {
      throw UsageError(
          fmt::format("{} is a value of the wrong type", py::repr(value).cast<std::string>()),
          {.column = name});
    }
  }
  /// The value itself; None if the argument is absent.
  py::object take(const char* name) {
    known_.emplace_back(name);
    return values_.attr("pop")(name, py::none());
  }

  /// \throws UsageError that names an argument that nobody took
  void finish() const {
    for (const auto& item : values_) {
      const auto name = py::str(item.first).cast<std::string>();
      throw UsageError("unknown argument" + did_you_mean(name, known_), {.column = name});
    }
  }

 private:
  py::dict values_;
  std::vector<std::string> known_{};
};

}  // namespace silvafit::python
