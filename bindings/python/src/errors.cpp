// SPDX-License-Identifier: MIT
#include "errors.hpp"

#include <exception>
#include <string>

#include "silvafit/study/error_kind.hpp"
#include "silvafit/study/setting_names.hpp"

namespace silvafit::python {
namespace {

namespace py = pybind11;

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
  const py::object types = py::module_::import("silvafit._errors").attr("KINDS");
  const py::object type = types[py::str(std::string(study::error_kind(error)))];
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
