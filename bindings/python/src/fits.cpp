// SPDX-License-Identifier: MIT
#include "fits.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "errors.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/parameter_values.hpp"
#include "silvafit/fit/response.hpp"
#include "silvafit/fit/summary.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/column_uses.hpp"
#include "silvafit/study/predict_responses.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "tables.hpp"

namespace silvafit::python {
namespace {

/// Names in texts: those read as numbers, with parameters, those read as names, and the response.
py::tuple uses(const std::string& formula,
               const std::vector<std::string>& parameters,
               const std::string& random,
               const std::string& variance,
               const std::string& correlation) {
  const study::ColumnUses found = study::column_uses({.formulas = {formula},
                                                      .parameters = parameters,
                                                      .random = random,
                                                      .variance = variance,
                                                      .correlation = correlation});
  return py::make_tuple(std::vector<std::string>(found.as_numbers.begin(), found.as_numbers.end()),
                        std::vector<std::string>(found.as_names.begin(), found.as_names.end()),
                        fit::response_of(formula));
}

/// Structural indices that sub-models read and the columns lack, as far as positions are known.
std::vector<std::string> structure_names(const std::vector<std::string>& texts,
                                         const std::vector<std::string>& columns) {
  data::Table header(0);
  for (const std::string& name : columns) header.set(name, std::vector<double>{});
  return study::structure_names_in(texts, header);
}

/// Adds structural indices, and the response if it is an expression; with notes.
py::tuple with_computed(const TablePointer& table,
                        const std::vector<std::string>& names,
                        const std::string& response) {
  data::Table result = *table;
  fit::add_response(response, result);
  std::vector<std::string> notes = study::add_structure_columns(names, result);
  for (std::string& note : notes) note = in_words_of_python(note);
  return py::make_tuple(share(std::move(result)), notes);
}

/// The random effects as text, `a + b | plot`; empty if there are none.
std::string random_text(const fit::FittedModel& fit) {
  std::string text;
  for (const fit::RandomEffects& term : fit.specification.random) {
    const std::string own = fmt::format("{} | {}", term.text(), term.group_text());
    if (!text.empty()) text += term.is_crossed ? " + " : "; ";
    text += term.is_crossed ? fmt::format("({})", own) : own;
  }
  return text;
}

py::list parameters_of(const fit::FittedModel& fit) {
  py::list result;
  for (const fit::NamedValue& value : fit::parameter_values(fit)) {
    result.append(py::make_tuple(value.name, value.value));
  }
  return result;
}

py::list models_of(const study::Catalogue& catalogue) {
  py::list result;
  for (const study::BaseModel& model : catalogue.models()) {
    py::dict one;
    one["id"] = model.id;
    one["name"] = model.name;
    one["response"] = model.response;
    one["formula"] = model.formula;
    one["parameters"] = model.parameter_names();
    one["covariates"] = model.covariates;
    result.append(one);
  }
  return result;
}

}  // namespace

void add_fits(py::module_& module) {
  using fit::FittedModel;
  // All other content is that of the JSON.
  py::class_<FittedModel, FitPointer>(module, "Fit")
      .def_property_readonly(
          "response", [](const FittedModel& self) { return self.specification.formula.left; })
      .def_property_readonly("response_columns",
                             [](const FittedModel& self) {
                               return fit::response_columns(self.specification.formula.left);
                             })
      .def_property_readonly(
          "predictors", [](const FittedModel& self) { return self.specification.predictors(); })
      .def_property_readonly(
          "verdict",
          [](const FittedModel& self) { return in_words_of_python(self.convergence.verdict()); })
      .def_property_readonly(
          "summary", [](const FittedModel& self) { return in_words_of_python(fit::summary(self)); })
      .def_property_readonly("has_doubts",
                             [](const FittedModel& self) { return self.convergence.has_doubts(); })
      .def_property_readonly(
          "variance", [](const FittedModel& self) { return self.specification.variance.text(); })
      .def_property_readonly(
          "columns",
          [](const FittedModel& self) { return study::columns_read(self.specification); })
      .def_property_readonly("random_text", &random_text)
      .def_property_readonly("parameter_values", &parameters_of)
      .def(
          "to_json",
          [](const FittedModel& self, int indent) { return fit::to_json(self, indent); },
          py::arg("indent") = -1)
      .def_static(
          "from_json",
          [](const std::string& text, const std::string& file) {
            return share(fit::from_json(text, file));
          },
          py::arg("text"),
          py::arg("file") = "");
  py::class_<study::Catalogue>(module, "Catalogue")
      .def(py::init([](const std::string& folder) { return study::Catalogue::load(folder); }),
           py::arg("models_directory"))
      .def("models", &models_of)
      .def("formula", [](const study::Catalogue& self, const std::string& id) {
        return self.find(id).formula;
      });
  module.def("uses", &uses);
  module.def("structure_names", &structure_names);
  module.def("with_computed", &with_computed);
}

}  // namespace silvafit::python
