// SPDX-License-Identifier: MIT
#include "fits.hpp"

#include <fmt/format.h>
#include <pybind11/eigen.h>
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

/// All columns that a fit reads for predictions.
std::vector<std::string> columns_of(const fit::FittedModel& fit) {
  std::vector<std::string> columns = fit.specification.label_columns();
  const std::vector<std::string> predictors = fit.specification.predictors();
  columns.insert(columns.end(), predictors.begin(), predictors.end());
  for (const fit::VarianceFactor& factor : fit.specification.variance.factors) {
    for (const std::string& name : {factor.column, factor.stratum}) {
      if (!name.empty()) columns.push_back(name);
    }
  }
  if (const auto& correlation = fit.specification.correlation) {
    columns.insert(columns.end(), correlation->columns.begin(), correlation->columns.end());
    if (!correlation->group.empty()) columns.push_back(correlation->group);
  }
  return columns;
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

py::dict variance_of(const fit::FittedModel& fit) {
  py::dict result;
  result["text"] = fit.specification.variance.text();
  result["delta"] = fit.variance.delta();
  result["constant"] = fit.variance.constant();
  return result;
}

std::string correlation_of(const fit::FittedModel& fit) {
  return fit.specification.correlation ? fit.specification.correlation->text() : "none";
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

/// Values that are the same for all fits.
void add_values(py::class_<fit::FittedModel, FitPointer>& fit) {
  using fit::FittedModel;
  fit.def_readonly("model", &FittedModel::model)
      .def_readonly("reml", &FittedModel::reml)
      .def_readonly("observations", &FittedModel::observations)
      .def_readonly("excluded", &FittedModel::excluded)
      .def_readonly("coefficient_names", &FittedModel::coefficient_names)
      .def_readonly("estimate", &FittedModel::estimate)
      .def_readonly("covariance", &FittedModel::covariance)
      .def_readonly("degrees_of_freedom", &FittedModel::degrees_of_freedom)
      .def_readonly("sigma", &FittedModel::sigma)
      .def_readonly("log_likelihood", &FittedModel::log_likelihood)
      .def_readonly("parameter_count", &FittedModel::parameter_count)
      .def_readonly("r2_marginal", &FittedModel::r2_marginal)
      .def_readonly("r2_conditional", &FittedModel::r2_conditional)
      .def_readonly("seconds", &FittedModel::seconds)
      .def_property_readonly("aic", &FittedModel::aic)
      .def_property_readonly("aicc", &FittedModel::aicc)
      .def_property_readonly("bic", &FittedModel::bic)
      .def_property_readonly("bic_groups", &FittedModel::bic_groups)
      .def_property_readonly("standard_errors", &FittedModel::standard_errors)
      .def_property_readonly("t_values", &FittedModel::t_values)
      .def_property_readonly("p_values", &FittedModel::p_values);
}

}  // namespace

void add_fits(py::module_& module) {
  using fit::FittedModel;
  py::class_<FittedModel, FitPointer> fit(module, "Fit");
  add_values(fit);
  fit.def_property_readonly("formula",
                            [](const FittedModel& self) { return self.specification.formula.text; })
      .def_property_readonly(
          "response", [](const FittedModel& self) { return self.specification.formula.left; })
      .def_property_readonly("response_columns",
                             [](const FittedModel& self) {
                               return fit::response_columns(self.specification.formula.left);
                             })
      .def_property_readonly(
          "predictors", [](const FittedModel& self) { return self.specification.predictors(); })
      .def_property_readonly("method",
                             [](const FittedModel& self) { return fit::method_text(self.method); })
      .def_property_readonly("converged",
                             [](const FittedModel& self) { return self.convergence.converged(); })
      .def_property_readonly("status",
                             [](const FittedModel& self) {
                               return std::string(fit::status_text(self.convergence.status));
                             })
      .def_property_readonly(
          "verdict",
          [](const FittedModel& self) { return in_words_of_python(self.convergence.verdict()); })
      .def_property_readonly(
          "summary", [](const FittedModel& self) { return in_words_of_python(fit::summary(self)); })
      .def_property_readonly("has_doubts",
                             [](const FittedModel& self) { return self.convergence.has_doubts(); })
      .def_property_readonly("variance", &variance_of)
      .def_property_readonly("correlation", &correlation_of)
      .def_property_readonly("columns", &columns_of)
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
