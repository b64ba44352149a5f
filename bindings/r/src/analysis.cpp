// SPDX-License-Identifier: MIT
// Analyses: arguments and tables of R, results as lists.
#include <R_ext/Print.h>

#include <algorithm>
#include <cpp11/list.hpp>
#include <cpp11/protect.hpp>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "conversion.hpp"
#include "entry_points.hpp"
#include "fit_handle.hpp"
#include "handle.hpp"
#include "silvafit/base/json_text.hpp"
#include "silvafit/data/json_reader.hpp"
#include "silvafit/study/analyses.hpp"
#include "silvafit/study/background.hpp"
#include "silvafit/study/setting_lists.hpp"

namespace silvafit::r {
namespace {

/// No signal reaches the threads that start while this lives: R handles them in its own thread.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_{};
};

/// Shows lines and the progress in the console, and keeps the notes.
class Console {
 public:
  explicit Console(bool shows_progress) : shows_progress_(shows_progress) {}
  ~Console() {
    if (!stage_.empty()) REprintf("\n");
  }
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void show(const study::Reports& reports) {
    notes_.insert(notes_.end(), reports.notes.begin(), reports.notes.end());
    for (const std::string& line : reports.lines) REprintf("%s\n", line.c_str());
    if (!shows_progress_ || reports.stage.empty()) return;
    if (!stage_.empty() && reports.stage != stage_) REprintf("\n");
    REprintf("\r%s %zu/%zu", reports.stage.c_str(), reports.done, reports.total);
    stage_ = reports.stage;
  }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  bool shows_progress_;
  std::vector<std::string> notes_{};
  std::string stage_{};
};

const study::ModelLibrary& library_of(SEXP handle) {
  return object_of<study::ModelLibrary>(handle, [](const std::string& json) {
    return study::read_library(data::JsonReader::parse(json, "the library"));
  });
}

/// \param objects  handles of fits, or that of a library
study::AnalysisInput input_of(SEXP table, SEXP plots, SEXP objects, SEXP arguments, SEXP folder) {
  study::AnalysisInput input{.data_folder = text_of(folder), .front = study::Front::kR};
  if (Rf_xlength(arguments) > 0) input.arguments = json_text(json_of(arguments));
  if (table != R_NilValue) input.table = source_of(table);
  if (plots != R_NilValue) input.plots = source_of(plots);
  if (TYPEOF(objects) == EXTPTRSXP) {
    input.library = &library_of(objects);
  } else if (objects != R_NilValue) {
    for (SEXP handle : cpp11::list(objects)) input.fits.push_back(&fit_of(handle));
  }
  return input;
}

/// \param notes  those of the console; warnings that are none of them are added
cpp11::sexp list_of(study::AnalysisResult result, std::vector<std::string> notes) {
  NamedList tables;
  for (const auto& [name, table] : result.tables) tables.add(name, columns_of(table));
  NamedList fits;
  for (auto& [label, fit] : result.fits) fits.add(label, list_of_fit(std::move(fit)));
  NamedList list;
  list.add("tables", tables.list());
  list.add("rows", row_numbers(result.rows));
  if (!result.json.empty()) {
    list.add("json", value_of(nlohmann::ordered_json::parse(result.json)));
  }
  list.add("fits", fits.list());
  for (const std::string& warning : result.warnings) {
    if (std::ranges::find(notes, warning) == notes.end()) notes.push_back(warning);
  }
  list.add("notes", value_of(notes));
  return list.list();
}

}  // namespace

SEXP analysis(
    SEXP name, SEXP table, SEXP plots, SEXP objects, SEXP arguments, SEXP folder, SEXP progress) {
  const study::AnalysisWork work =
      study::prepare_analysis(text_of(name), input_of(table, plots, objects, arguments, folder));
  Console console(LOGICAL(progress)[0] == TRUE);
  std::optional<BlockedSignals> blocked(std::in_place);  // until the thread has started
  study::AnalysisResult result = study::run_in_background(work, [&](const study::Reports& reports) {
    blocked.reset();
    console.show(reports);
    // An interrupt, or the error of a time limit.
    cpp11::check_user_interrupt();
  });
  return list_of(std::move(result), console.notes());
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

SEXP formula_of_model(SEXP id, SEXP folder) {
  const std::filesystem::path models = std::filesystem::path(text_of(folder)) / "models";
  return value_of(study::Catalogue::load(models).find(text_of(id)).formula);
}

/// A library: its handle, a description of each model, and their fits.
SEXP read_library(SEXP file, SEXP folder) {
  study::ModelLibrary library =
      study::find_library(text_of(file), std::filesystem::path(text_of(folder)) / "models");
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

}  // namespace silvafit::r
