// SPDX-License-Identifier: MIT
// Analyses: arguments as JSON and tables of Python, results as a dictionary; libraries; lists of
// settings.
#include <pybind11/stl.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "errors.hpp"
#include "fits.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/study/analyses.hpp"
#include "silvafit/study/background.hpp"
#include "silvafit/study/model_library.hpp"
#include "tables.hpp"

namespace silvafit::python {
namespace {

/// Calls listener(kind, text, done, total) with reports: "note", "line" and "progress".
void tell(const study::Reports& reports, const py::object& listener) {
  for (const std::string& note : reports.notes) listener("note", in_words_of_python(note), 0, 0);
  for (const std::string& line : reports.lines) listener("line", line, 0, 0);
  if (!reports.stage.empty()) listener("progress", reports.stage, reports.done, reports.total);
}

/// \param table, plots  a path, a Table or None
/// \param library       the library of predictions, or None
py::dict analysis(const std::string& name,
                  const std::string& arguments,
                  const py::object& table,
                  const py::object& plots,
                  const std::vector<FitPointer>& fits,
                  const study::ModelLibrary* library,
                  const std::string& data_folder,
                  const study::Catalogue* catalogue,
                  const py::object& listener) {
  study::AnalysisInput input{.arguments = arguments,
                             .library = library,
                             .data_folder = data_folder,
                             .catalogue = catalogue,
                             .front = study::Front::kPython};
  if (!table.is_none()) input.table = source_of(table);
  if (!plots.is_none()) input.plots = source_of(plots);
  for (const FitPointer& fit : fits) input.fits.push_back(fit.get());
  const study::AnalysisWork prepared = study::prepare_analysis(name, std::move(input));
  const auto poll = [&listener](const study::Reports& reports) {
    if (!listener.is_none()) tell(reports, listener);
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  };
  const auto wait = [](const std::function<void()>& waits) {
    const py::gil_scoped_release other_threads_run;
    waits();
  };
  study::AnalysisResult found = study::run_in_background(prepared, poll, wait);
  py::dict tables;
  for (auto& [key, content] : found.tables) tables[py::str(key)] = share(std::move(content));
  py::list made;
  for (auto& [label, fit] : found.fits) made.append(py::make_tuple(label, share(std::move(fit))));
  py::dict result;
  result["tables"] = tables;
  result["rows"] = found.rows;
  result["label_columns"] = found.label_columns;
  result["json"] = found.json;
  result["fits"] = made;
  result["library"] = std::move(found.library);
  for (std::string& warning : found.warnings) warning = in_words_of_python(warning);
  result["warnings"] = found.warnings;
  return result;
}

py::list models_of(const study::ModelLibrary& library) {
  py::list models;
  for (const study::LibraryModel& model : library.models) {
    models.append(py::dict(py::arg("species") = model.species,
                           py::arg("response") = model.response,
                           py::arg("unit") = model.unit,
                           py::arg("role") = model.role,
                           py::arg("fit") = share(model.fit)));
  }
  return models;
}

study::ModelLibrary library_of(const std::vector<FitPointer>& fits) {
  study::ModelLibrary library;
  for (const FitPointer& fit : fits) {
    library.models.push_back({.response = fit->specification.formula.left, .fit = *fit});
  }
  return library;
}

}  // namespace

void add_analyses(py::module_& module) {
  py::class_<study::ModelLibrary>(module, "Library")
      .def_static(
          "read",
          [](const std::string& name_or_file, const std::string& models) {
            return study::find_library(name_or_file, models);
          },
          py::arg("name_or_file"),
          py::arg("models"))
      .def_static(
          "from_json",
          [](const std::string& text) {
            return study::read_library(data::JsonReader::parse(text, ""));
          },
          py::arg("text"))
      .def_static("of", &library_of, py::arg("fits"))
      .def("models", &models_of)
      .def("to_json", [](const study::ModelLibrary& self) { return study::to_json(self); })
      .def("write", [](const study::ModelLibrary& self, const std::string& path) {
        study::write_library(self, path);
      });
  module.def("analysis", &analysis);
}

}  // namespace silvafit::python
