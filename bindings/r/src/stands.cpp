// SPDX-License-Identifier: MIT
// Analyses of inventories: structural units, stand tables, imputation, studies, libraries.
#include <algorithm>
#include <cpp11/list.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "background.hpp"
#include "conversion.hpp"
#include "entry_points.hpp"
#include "fit_handle.hpp"
#include "handle.hpp"
#include "settings.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/impute_table.hpp"
#include "silvafit/study/indices.hpp"
#include "silvafit/study/model_library.hpp"
#include "silvafit/study/predict_table.hpp"
#include "silvafit/study/setting_lists.hpp"
#include "silvafit/study/setting_names.hpp"
#include "silvafit/study/stand_growth.hpp"
#include "silvafit/study/stand_summary.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/whole_study.hpp"

namespace silvafit::r {
namespace {

study::Catalogue catalogue_of(const Arguments& arguments) {
  return study::Catalogue::load(data_folder(arguments) / "models");
}

/// Numbers of the rows of a data frame that an inventory has kept.
cpp11::sexp rows_of(const stand::Inventory& inventory) {
  return row_numbers({inventory.lines.begin(), inventory.lines.end()}, 1);
}

study::StandOptions stand_options(const Arguments& arguments) {
  auto options = settings_of<study::StandOptions>(arguments);
  options.reading = reading_settings(arguments);
  options.units = unit_settings(arguments);
  options.sampling = sampling_settings(arguments);
  arguments.read("threads", options.threads);
  options.equations = equation_settings(arguments);
  return options;
}

/// Tables under their names, what --json prints, and the notes.
SEXP results_of(const std::vector<std::pair<std::string, data::Table>>& tables,
                const nlohmann::ordered_json& json,
                const std::vector<std::string>& notes) {
  NamedList named;
  for (const auto& [name, table] : tables) named.add(name, columns_of(table));
  NamedList list;
  list.add("tables", named.list());
  list.add("json", value_of(json));
  list.add("notes", value_of(notes));
  return list.list();
}

}  // namespace

SEXP structural_units(SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  study::IndicesOptions options{.reading = reading_settings(arguments),
                                .units = unit_settings(arguments),
                                .sampling = sampling_settings(arguments)};
  arguments.read("threads", options.threads);
  const auto [result, notes] = in_background(
      [&](Reports& reports) { return study::tree_indices(trees, options, reports.callbacks()); },
      shows_progress(arguments));
  NamedList list;
  list.add("table", columns_of(result.table()));
  list.add("rows", rows_of(result.inventory.inventory));
  list.add("summary", value_of(study::json_of(result.summary)));
  list.add("notes", value_of(notes));
  return list.list();
}

SEXP stand_summary(SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  const study::StandOptions options = stand_options(arguments);
  const auto [result, notes] = in_background(
      [&](Reports& reports) { return study::stand_summary(trees, options, reports.callbacks()); },
      shows_progress(arguments));
  return results_of(stand::tables_of(result.report), study::json_of(result), notes);
}

SEXP stand_growth(SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  const study::StandOptions options = stand_options(arguments);
  const auto [result, notes] = in_background(
      [&](Reports& reports) { return study::stand_growth(trees, options, reports.callbacks()); },
      shows_progress(arguments));
  return results_of(stand::tables_of(result.report), study::json_of(result), notes);
}

SEXP impute_table(SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  const study::Catalogue catalogue = catalogue_of(arguments);
  const study::ReadingSettings reading = reading_settings(arguments);
  auto options = settings_of<study::ImputeOptions>(arguments);
  arguments.read("threads", options.threads);
  arguments.read("seed", options.seed);
  const auto [result, notes] = in_background(
      [&](Reports& reports) {
        return study::impute_table(trees, catalogue, options, reading, reports.callbacks());
      },
      shows_progress(arguments));
  NamedList fits;
  for (const study::ImputeModel& model : result.imputation.models) {
    fits.add(model.label, list_of_fit(model.fit));
  }
  NamedList list;
  list.add("columns", columns_of(study::imputed_columns(result)));
  list.add("fits", fits.list());
  list.add("sentences", value_of(study::summary_of(result)));
  list.add("notes", value_of(notes));
  return list.list();
}

/// The settings of some lists: names, arguments of R and meanings.
SEXP setting_list(SEXP lists) {
  std::vector<std::string> names;
  std::vector<std::string> arguments;
  std::vector<std::string> help;
  const std::vector<std::string> wanted = texts_of(lists);
  study::each_setting_list([&](std::string_view list, const auto& settings) {
    if (std::ranges::find(wanted, list) == wanted.end()) return;
    each_setting(settings, [&](const auto& setting) {
      names.emplace_back(setting.key);
      arguments.emplace_back(study::argument_of_r(setting.key));
      help.emplace_back(setting.help);
    });
  });
  NamedList result;
  result.add("name", value_of(names));
  result.add("argument", value_of(arguments));
  result.add("help", value_of(help));
  return result.list();
}

SEXP study_of(SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  const study::Catalogue catalogue = catalogue_of(arguments);
  study::StudyConfiguration configuration = study_settings(arguments, catalogue);
  arguments.read("threads", configuration.study.threads);
  const std::filesystem::path folder = text_of(arguments["out"]);
  const std::filesystem::path page = data_folder(arguments) / "viewer" / "report.html";
  study::StudyRecord record;
  std::vector<std::string> notes = run_in_background(
      [&](Reports& reports) {
        record = study::whole_study(trees, catalogue, configuration, reports.callbacks());
        record.command = "silvafit::fit_study()";
        study::write_study(record, catalogue, page, folder);
      },
      shows_progress(arguments));
  NamedList list;
  list.add("summary", value_of(study::json_of(record, folder)));
  list.add("notes", value_of(notes));
  return list.list();
}

namespace {

/// A library in R: its handle, a description of each model, and their fits.
cpp11::sexp list_of(study::ModelLibrary library) {
  nlohmann::ordered_json models = nlohmann::ordered_json::array();
  NamedList fits;
  for (const study::LibraryModel& model : library.models) {
    models.push_back(
        {{"species", model.species}, {"response", model.response}, {"role", model.role}});
    fits.add("", list_of_fit(model.fit));
  }
  NamedList list;
  list.add("models", value_of(models));
  list.add("fits", fits.list());
  const std::string json = study::to_json(library);
  list.add("handle", handle_of(std::move(library), json));
  return list.list();
}

}  // namespace

SEXP read_library(SEXP file, SEXP folder) {
  return list_of(
      study::find_library(text_of(file), std::filesystem::path(text_of(folder)) / "models"));
}

SEXP predict_library(SEXP library, SEXP source, SEXP settings) {
  const Arguments arguments(settings);
  const data::TableSource trees = source_of(source);
  const study::Catalogue catalogue = catalogue_of(arguments);
  const auto& models = object_of<study::ModelLibrary>(library, [](const std::string& json) {
    return study::read_library(data::JsonReader::parse(json, "the library"));
  });
  auto options = settings_of<study::PredictionSettings>(arguments);
  options.reading = reading_settings(arguments);
  options.equations = equation_settings(arguments);
  arguments.read("threads", options.threads);
  const auto [result, notes] = in_background(
      [&](Reports& reports) {
        return study::predict_table(trees, models, catalogue, options, reports.callbacks());
      },
      shows_progress(arguments));
  NamedList list;
  list.add("columns", columns_of(study::new_columns(result)));
  list.add("notes", value_of(notes));
  return list.list();
}

}  // namespace silvafit::r
