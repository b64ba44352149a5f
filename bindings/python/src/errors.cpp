// SPDX-License-Identifier: MIT
#include "errors.hpp"

#include <exception>
#include <string>

#include "silvafit/base/error.hpp"
#include "silvafit/base/io_error.hpp"
#include "silvafit/study/setting_names.hpp"

namespace silvafit::python {
namespace {

namespace py = pybind11;

/// From the most special to the base.
const char* class_of(const Error& error) {
  if (dynamic_cast<const FormulaError*>(&error) != nullptr) return "FormulaError";
  if (dynamic_cast<const UsageError*>(&error) != nullptr) return "UsageError";
  if (dynamic_cast<const DomainError*>(&error) != nullptr) return "DomainError";
  if (dynamic_cast<const InputError*>(&error) != nullptr) return "InputError";
  if (dynamic_cast<const NumericalError*>(&error) != nullptr) return "NumericalError";
  if (dynamic_cast<const GeometryError*>(&error) != nullptr) return "GeometryError";
  if (dynamic_cast<const IoError*>(&error) != nullptr) return "FileError";
  return "Error";
}

void raise(const Error& error) {
  const Place& place = error.place();
  py::dict where;
  const auto add = [&where](const char* name, const std::string& value) {
    if (!value.empty()) where[name] = value;
  };
  add("file", place.file);
  add("column", study::name_of_place(place.column));
  add("plot", place.plot);
  add("tree", place.tree);
  add("model", place.model);
  if (place.line) where["line"] = *place.line;
  if (const auto* const formula = dynamic_cast<const FormulaError*>(&error)) {
    where["position"] = formula->position();
  }
  const py::object type = py::module_::import("silvafit._errors").attr(class_of(error));
  const py::object exception = type(in_words_of_python(error.message()), **where);
  PyErr_SetObject(type.ptr(), exception.ptr());
}

}  // namespace

std::string in_words_of_python(std::string_view message) {
  return study::with_setting_names(message, study::Front::kPython);
}

void add_errors(py::module_& /*module*/) {
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const Error& error) {
      raise(error);
    }
  });
}

}  // namespace silvafit::python
