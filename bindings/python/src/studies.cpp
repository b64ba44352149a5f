// SPDX-License-Identifier: MIT
#include "studies.hpp"

#include <pybind11/stl.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fits.hpp"
#include "reading.hpp"
#include "setting_keywords.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/impute_table.hpp"
#include "silvafit/study/indices.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/stand_growth.hpp"
#include "silvafit/study/stand_summary.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/whole_study.hpp"
#include "tables.hpp"
#include "work.hpp"

namespace silvafit::python {
namespace {

/// Numbers of the rows that an inventory was read from, from 0.
std::vector<std::size_t> rows_of(const stand::Inventory& inventory) {
  std::vector<std::size_t> rows;
  for (const std::uint32_t line : inventory.lines) rows.push_back(line - 1);
  return rows;
}

py::dict structural_units(const py::object& trees,
                          const py::dict& keywords,
                          const py::object& listener) {
  Arguments arguments(keywords);
  study::IndicesOptions options{.reading = take_reading(arguments),
                                .units = take_units(arguments),
                                .sampling = take_sampling(arguments)};
  arguments.take("threads", options.threads);
  arguments.finish();
  const data::TableSource source = source_of(trees);
  const study::TreeIndices found = run(
      listener, [&](Work& work) { return study::tree_indices(source, options, work.callbacks()); });
  py::dict result;
  result["table"] = share(found.table());
  result["rows"] = rows_of(found.inventory.inventory);
  result["json"] = study::json_of(found.summary).dump();
  return result;
}

study::StandOptions stand_options(Arguments& arguments) {
  auto options = settings_of<study::StandOptions>(arguments);
  options.reading = take_reading(arguments);
  options.units = take_units(arguments);
  options.sampling = take_sampling(arguments);
  options.equations = take_equations(arguments);
  arguments.take("threads", options.threads);
  arguments.finish();
  return options;
}

/// Tables under their names, and what --json prints.
py::dict results_of(std::vector<std::pair<std::string, data::Table>> tables,
                    const nlohmann::ordered_json& json) {
  py::list list;
  for (auto& [name, table] : tables) list.append(py::make_tuple(name, share(std::move(table))));
  py::dict result;
  result["tables"] = list;
  result["json"] = json.dump();
  return result;
}

py::dict stand_summary(const py::object& trees,
                       const py::dict& keywords,
                       const py::object& listener) {
  Arguments arguments(keywords);
  const study::StandOptions options = stand_options(arguments);
  const data::TableSource source = source_of(trees);
  const study::StandSummary found = run(listener, [&](Work& work) {
    return study::stand_summary(source, options, work.callbacks());
  });
  return results_of(stand::tables_of(found.report), study::json_of(found));
}

py::dict stand_growth(const py::object& trees,
                      const py::dict& keywords,
                      const py::object& listener) {
  Arguments arguments(keywords);
  const study::StandOptions options = stand_options(arguments);
  const data::TableSource source = source_of(trees);
  const study::GrowthSummary found = run(
      listener, [&](Work& work) { return study::stand_growth(source, options, work.callbacks()); });
  return results_of(stand::tables_of(found.report), study::json_of(found));
}

py::dict impute(const py::object& trees,
                const study::Catalogue& catalogue,
                const py::dict& keywords,
                const py::object& listener) {
  Arguments arguments(keywords);
  auto options = settings_of<study::ImputeOptions>(arguments);
  arguments.take("seed", options.seed);
  arguments.take("threads", options.threads);
  const study::ReadingSettings reading = take_reading(arguments);
  arguments.finish();
  const data::TableSource source = source_of(trees);
  const study::TableImputation found = run(listener, [&](Work& work) {
    return study::impute_table(source, catalogue, options, reading, work.callbacks());
  });
  py::list models;
  for (const study::ImputeModel& model : found.imputation.models) {
    models.append(py::make_tuple(model.label, share(model.fit)));
  }
  py::dict result;
  result["table"] = share(study::imputed_columns(found));
  result["rows"] = python::rows_of(found.table);
  result["models"] = models;
  result["summary"] = study::summary_of(found);
  return result;
}

py::list models_of(const study::ModelLibrary& library) {
  py::list models;
  for (const study::LibraryModel& model : library.models) {
    py::dict one;
    one["species"] = model.species;
    one["response"] = model.response;
    one["unit"] = model.unit;
    one["role"] = model.role;
    one["fit"] = share(model.fit);
    models.append(one);
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

study::PredictionSettings prediction_settings(const py::dict& keywords) {
  Arguments arguments(keywords);
  auto settings = settings_of<study::PredictionSettings>(arguments);
  settings.reading = take_reading(arguments);
  settings.equations = take_equations(arguments);
  arguments.take("threads", settings.threads);
  arguments.finish();
  return settings;
}

py::dict predict(const study::ModelLibrary& library,
                 const py::object& trees,
                 const study::Catalogue& catalogue,
                 const py::dict& keywords,
                 const py::object& listener) {
  const study::PredictionSettings settings = prediction_settings(keywords);
  const data::TableSource source = source_of(trees);
  const study::TablePrediction found = run(listener, [&](Work& work) {
    return study::predict_table(source, library, catalogue, settings, work.callbacks());
  });
  py::dict result;
  result["table"] = share(study::new_columns(found));
  result["rows"] = python::rows_of(found.table);
  return result;
}

/// Arguments of a study besides its settings.
struct StudyRequest {
  std::string settings{};  ///< a study.json, or a file with the keywords
  std::string out{};       ///< empty: no files
  std::string page{};      ///< the bundled report page
  std::string call{};      ///< as the report shows it
  unsigned threads = 0;
  std::vector<stand::NamedWindow> windows{};
  std::optional<data::TableSource> plots{};  ///< in memory
};

StudyRequest study_request(const py::dict& keywords) {
  Arguments arguments(keywords);
  StudyRequest request;
  py::object windows = py::none();
  py::object plots = py::none();
  arguments.take("plots", plots);
  arguments.take("settings", request.settings);
  arguments.take("out", request.out);
  arguments.take("page", request.page);
  arguments.take("call", request.call);
  arguments.take("threads", request.threads);
  arguments.take("windows", windows);
  arguments.finish();
  request.windows = windows_of(windows);
  if (!plots.is_none()) request.plots = source_of(plots);
  return request;
}

struct StudyResult {
  study::ModelLibrary library{};
  data::Table predictions{};
  std::vector<std::size_t> rows{};
  std::string json{};
};

StudyResult study_of(const data::TableSource& source,
                     const study::Catalogue& catalogue,
                     StudyRequest& request,
                     Work& work) {
  study::StudyConfiguration settings =
      study::read_study_configuration(request.settings, &catalogue);
  settings.study.threads = request.threads;
  settings.units.windows = std::move(request.windows);
  if (request.plots) settings.sampling.plots = std::move(request.plots);
  study::StudyRecord record = study::whole_study(source, catalogue, settings, work.callbacks());
  record.command = request.call;
  if (!request.out.empty()) study::write_study(record, catalogue, request.page, request.out);
  StudyResult result{.library = study::library_of(record)};
  result.predictions = study::predictions_of(record, result.library);
  result.rows = rows_of(record.inventory.inventory);
  result.json = study::json_of(record, request.out).dump();
  return result;
}

py::dict study_results(const py::object& trees,
                       const study::Catalogue& catalogue,
                       const py::dict& keywords,
                       const py::object& listener) {
  StudyRequest request = study_request(keywords);
  const data::TableSource source = source_of(trees);
  StudyResult found =
      run(listener, [&](Work& work) { return study_of(source, catalogue, request, work); });
  py::dict result;
  result["library"] = std::move(found.library);
  result["predictions"] = share(std::move(found.predictions));
  result["rows"] = found.rows;
  result["json"] = found.json;
  return result;
}

}  // namespace

void add_studies(py::module_& module) {
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
      .def("write",
           [](const study::ModelLibrary& self, const std::string& path) {
             study::write_library(self, path);
           })
      .def("predict", &predict);
  module.def("structural_units", &structural_units);
  module.def("stand_summary", &stand_summary);
  module.def("stand_growth", &stand_growth);
  module.def("impute", &impute);
  module.def("study", &study_results);
}

}  // namespace silvafit::python
