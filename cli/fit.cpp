// SPDX-License-Identifier: MIT
// `silvafit fit`: one model or several, by least squares or with mixed effects.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "command.hpp"
#include "fit_resampling.hpp"
#include "output_files.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/data/checked_columns.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "silvafit/fit/response.hpp"
#include "silvafit/fit/setting_list.hpp"
#include "silvafit/fit/shared_fit.hpp"
#include "silvafit/fit/summary.hpp"
#include "silvafit/stand/similar_plots.hpp"
#include "silvafit/stand/tree_columns.hpp"
#include "silvafit/study/catalogue.hpp"
#include "silvafit/study/column_uses.hpp"
#include "silvafit/study/shared_table.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "silvafit/study/table_checks.hpp"
#include "silvafit/study/tree_table.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

struct FitArguments {
  CommonOptions common{};
  TableArguments table{};
  std::string data{};
  std::vector<std::string> models{};  ///< of the catalogue, instead of a formula
  fit::ModelTexts texts{};
  fit::FitModelOptions options{};
  bool trace = false;
  bool shares_groups = false;
  std::string where{};
  study::ReadingSettings reading{};
  fit::IntervalOptions intervals{};
  bool has_intervals = false;
  ResamplingArguments resampling{};
};

/// One model to fit.
struct Task {
  std::string id{};
  fit::ModelSpecification specification;
  fit::FitModelOptions options{};
};

/// The columns that models of the catalogue need; none for a formula, whose names are columns of
/// the file.
std::vector<std::string> columns_read(const std::vector<const study::BaseModel*>& models,
                                      const std::vector<std::string>& names) {
  if (models.empty()) return {};
  std::vector<std::string> columns = names;
  for (const study::BaseModel* const model : models) {
    columns.push_back(model->response);
    columns.insert(columns.end(), model->covariates.begin(), model->covariates.end());
  }
  return columns;
}

study::ModelColumns model_columns(const FitArguments& arguments,
                                  const std::vector<const study::BaseModel*>& models) {
  std::vector<std::string> formulas;
  const fit::ModelTexts& texts = arguments.texts;
  if (!texts.formula.empty()) formulas.push_back(texts.formula);
  for (const study::BaseModel* const model : models) formulas.push_back(model->formula);
  const std::vector<std::string> names = study::name_columns({.formulas = formulas,
                                                              .parameters = texts.sub_models,
                                                              .where = arguments.where,
                                                              .random = texts.random,
                                                              .variance = texts.variance,
                                                              .correlation = texts.correlation});
  return {.names = names,
          .random = texts.random,
          .wanted = columns_read(models, names),
          .keeps_spellings = true};
}

/// Says that codes of species, plots or trees are a slope in a sub-model.
void say_numeric_labels(const FitArguments& arguments, const data::Table& table) {
  for (const std::string& text : arguments.texts.sub_models) {
    for (const std::string& name : fit::sub_model_columns(text).as_numbers) {
      if (!table.has(name) || !table.is_numeric(name)) continue;
      for (const char* const label : {"species", "plot", "tree"}) {
        if (stand::fields_of(label, {name}, {}, table.file()).empty()) continue;
        say(arguments.common,
            fmt::format("note: {} is a number in \"{}\", a slope over its codes; for a value of "
                        "each {} write factor({})",
                        name,
                        text,
                        label,
                        name));
        break;
      }
    }
  }
}

/// Names labels of sub-models that may be the same; those that the formulas name as labels are
/// compared when the table is read.
void say_similar_labels(const FitArguments& arguments, const data::Table& table) {
  std::set<std::string> factors;
  for (const std::string& text : arguments.texts.sub_models) {
    const auto used = fit::sub_model_columns(text).as_numbers;
    factors.insert(used.begin(), used.end());
  }
  for (const std::string& name : factors) {
    if (!table.has(name) || table.is_numeric(name)) continue;
    const std::string note = stand::describe_similar_labels(table.text(name), name);
    if (!note.empty()) say(arguments.common, "note: " + note);
  }
}

study::ReadTable read_data(const FitArguments& arguments,
                           const std::vector<const study::BaseModel*>& models) {
  const TreeTable trees = open_trees(arguments.data, arguments.table, arguments.common);
  Progress progress(arguments.common);
  study::ObservedTable read = study::read_model_table(trees.table,
                                                      arguments.reading,
                                                      model_columns(arguments, models),
                                                      callbacks(arguments.common, progress).note);
  data::Table table = read.observations();
  if (table.rows() == 0) {
    throw InputError("there are no rows below the header", {.file = table.file()});
  }
  // Covariates must be columns. If the file lacks one with the name of a structural index, the
  // index is computed. In the formula itself the name may be a parameter.
  say_numeric_labels(arguments, table);
  say_similar_labels(arguments, table);
  std::vector<std::string> texts = arguments.texts.sub_models;
  texts.push_back(arguments.where);
  const std::vector<std::string> indices = study::structure_names_in(texts, table);
  for (const std::string& note : study::add_structure_columns(indices, table)) {
    say(arguments.common, "note: " + note);
  }
  const std::string& formula = arguments.texts.formula;
  if (!formula.empty()) fit::add_response(fit::response_of(formula), table);
  const auto note = [&arguments](const std::string& text) {
    if (!text.empty()) say(arguments.common, "note: " + text);
  };
  if (!arguments.where.empty()) {
    note(data::describe_compared_texts(arguments.where, table));
    table = data::rows_where(arguments.where, table);
  }
  if (!formula.empty()) note(study::leave_out_negative(fit::response_of(formula), table));
  for (const study::BaseModel* const model : models) {
    note(study::leave_out_impossible(model->response, table));
  }
  return {.table = std::move(table), .recognized = std::move(read.recognized)};
}

/// A model with the options that all models of a command have in common.
/// \param model  of the catalogue; null for a formula
Task task_of(const study::BaseModel* model,
             const FitArguments& arguments,
             const data::Table& table) {
  const std::string id = model != nullptr ? model->id : "";
  fit::ModelTexts texts = arguments.texts;
  fit::FitModelOptions options = arguments.options;
  if (model != nullptr) study::use_base_model(*model, table, texts, options);
  if (arguments.trace) {
    options.trace = [id](const std::string& line) {
      write_to_standard_error(fmt::format("{}{}{}\n", id, id.empty() ? "" : ": ", line));
    };
  }
  return {
      .id = id, .specification = fit::specify_model(texts, table), .options = std::move(options)};
}

std::vector<const study::BaseModel*> chosen_models(const study::Catalogue& catalogue,
                                                   const std::vector<std::string>& names) {
  constexpr std::string_view kAll = "all:";
  std::vector<const study::BaseModel*> models;
  for (const std::string& name : names) {
    if (!name.starts_with(kAll)) {
      models.push_back(&catalogue.find(name));
      continue;
    }
    const auto candidates = catalogue.candidates(name.substr(kAll.size()));
    if (candidates.empty()) {
      throw UsageError(fmt::format("the catalogue has candidates for h, hcb and cw, not for '{}'",
                                   name.substr(kAll.size())),
                       {.column = "--model"});
    }
    models.insert(models.end(), candidates.begin(), candidates.end());
  }
  return models;
}

/// \param models  of the catalogue; none for a formula
std::vector<Task> tasks_of(const FitArguments& arguments,
                           const std::vector<const study::BaseModel*>& models,
                           const data::Table& table) {
  if (models.empty()) return {task_of(nullptr, arguments, table)};
  std::vector<Task> tasks;
  for (const study::BaseModel* const model : models) {
    tasks.push_back(task_of(model, arguments, table));
  }
  return tasks;
}

/// Threads of each fit, such that all fits together use the requested number.
unsigned threads_of_one(const CommonOptions& common, std::size_t fits) {
  if (fits == 1) return common.threads;
  const unsigned all =
      common.threads > 0 ? common.threads : std::max(1U, std::thread::hardware_concurrency());
  return std::max(1U, all / static_cast<unsigned>(fits));
}

void add_intervals(const FitArguments& arguments,
                   unsigned threads,
                   const data::Table& table,
                   fit::FittedModel& fit) {
  if (!arguments.has_intervals || !fit.convergence.converged()) return;
  fit::IntervalOptions options = arguments.intervals;
  options.threads = threads;
  fit.intervals = fit::confidence_intervals(fit, table, options);
}

std::vector<fit::FittedModel> fit_all(const std::vector<Task>& tasks,
                                      const data::Table& table,
                                      const FitArguments& arguments) {
  const CommonOptions& common = arguments.common;
  std::vector<std::optional<fit::FittedModel>> fits(tasks.size());
  Progress progress(common);
  std::atomic<std::size_t> done{0};
  const unsigned threads = threads_of_one(common, tasks.size());
  const auto texts = farm(tasks.size(), common.threads, [&](std::size_t i) {
    fit::FitModelOptions options = tasks[i].options;
    options.threads = threads;
    fits[i] = fit::fit_model(tasks[i].specification, table, options).fit;
    fits[i]->model = tasks[i].id;
    // A single fit uses all threads.
    add_intervals(arguments, tasks.size() > 1 ? 1 : common.threads, table, *fits[i]);
    progress.show("fitting", ++done, tasks.size());
    return fit::to_json(*fits[i]);
  });
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (!fits[i]) fits[i] = fit::from_json(texts[i], "fit of another process");
  }
  std::vector<fit::FittedModel> result;
  result.reserve(fits.size());
  for (auto& fit : fits) result.push_back(*std::move(fit));
  return result;
}

/// The fit of one model to groups that are distributed over the processes of a job.
/// \param recognized  gets the notes on how the file was read
fit::FittedModel fit_of_shared(const FitArguments& arguments,
                               const std::vector<const study::BaseModel*>& models,
                               std::vector<std::string>& recognized) {
  const std::string group = fit::parse_random_effects(arguments.texts.random).front().group;
  const TreeTable trees = open_trees(arguments.data, arguments.table, arguments.common);
  Progress progress(arguments.common);
  study::SharedTable read = study::read_shared_table(trees.table,
                                                     arguments.reading,
                                                     model_columns(arguments, models),
                                                     group,
                                                     arguments.where,
                                                     callbacks(arguments.common, progress).note);
  recognized = std::move(read.recognized);
  const std::vector<Task> tasks = tasks_of(arguments, models, read.data.sample);
  for (const study::BaseModel* const model : models) {
    if (!read.data.own) continue;
    study::require_domain(*model, *read.data.own);
    study::require_possible(model->response, *read.data.own);
  }
  fit::FitModelOptions options = tasks.front().options;
  options.threads = arguments.common.threads;
  fit::FittedModel fit =
      fit::fit_shared(tasks.front().specification, std::move(read.data), options);
  fit.model = tasks.front().id;
  return fit;
}

/// \param recognized  the notes on how the file was read
void print_json(const std::vector<fit::FittedModel>& fits,
                const std::vector<Resampling>& resampling,
                const std::vector<std::string>& recognized) {
  if (fits.size() == 1) {
    print_text("{}\n",
               with_resampling(fit::to_json(fits.front(), 2), resampling.front(), recognized));
    return;
  }
  print_text("{{\"fits\": [\n");
  for (std::size_t i = 0; i < fits.size(); ++i) {
    print_text("{}{}\n",
               with_resampling(fit::to_json(fits[i], 2), resampling[i], recognized),
               i + 1 < fits.size() ? "," : "");
  }
  print_text("]}}\n");
}

void print_tables(const std::vector<fit::FittedModel>& fits) {
  if (fits.size() == 1) {
    print_text("{}", with_options(fit::summary(fits.front())));
    return;
  }
  std::vector<const fit::FittedModel*> pointers;
  pointers.reserve(fits.size());
  for (const fit::FittedModel& fit : fits) pointers.push_back(&fit);
  print_text("{}", with_options(fit::ranking(pointers)));
}

/// Options that have no effect without another one.
void refuse_idle_options(const CLI::App& command, const FitArguments& arguments) {
  const bool bootstraps = arguments.resampling.bootstrap.replicates > 0;
  const bool cross_validates = arguments.resampling.cross_validates;
  const study::GivenName given = given_options(command);
  study::refuse_idle(arguments.texts, arguments.options, given);
  study::refuse_idle_settings(arguments.resampling.bootstrap, given);
  refuse_idle(command, "--level", arguments.has_intervals, "--intervals");
  refuse_idle(command, "--measured-trees", cross_validates, "--cross-validate");
  refuse_idle(command, "--group", bootstraps || cross_validates, "--bootstrap or --cross-validate");
  const bool has_groups =
      !arguments.resampling.bootstrap.group.empty() || !arguments.texts.random.empty();
  if (cross_validates && !has_groups) {
    throw UsageError(
        "a model without random effects has no groups to leave out; name their column, for example "
        "--group plot",
        {.column = "--cross-validate"});
  }
}

/// Fewer folds than asked for, and groups of measured trees only.
void note_on_folds(const std::vector<Resampling>& resampling, const FitArguments& arguments) {
  const std::size_t asked = arguments.resampling.cross_validation.folds;
  for (const Resampling& one : resampling) {
    if (!one.cross_validation) continue;
    const fit::CrossValidation& result = *one.cross_validation;
    if (result.measured > 0 && result.calibrated_count == 0) {
      say(arguments.common,
          fmt::format("note: no {} has more than {} trees, so that none is left to predict with "
                      "measured ones; choose a smaller --measured-trees",
                      result.group,
                      result.measured));
    }
    if (result.folds >= asked) continue;
    say(arguments.common,
        fmt::format("note: {} folds instead of {}: the column {} has {} groups",
                    result.folds,
                    asked,
                    result.group,
                    result.groups));
    return;
  }
}

void refuse_with_shared_groups(const FitArguments& arguments) {
  const ResamplingArguments& resampling = arguments.resampling;
  const bool has_others = resampling.bootstrap.replicates > 0 || resampling.cross_validates ||
                          !resampling.residuals.empty() || arguments.has_intervals;
  const char* reason = nullptr;
  if (arguments.texts.random.empty()) reason = "needs --random, whose groups are shared";
  if (arguments.models.size() > 1) reason = "fits one model";
  if (has_others) reason = "has no --bootstrap, --cross-validate, --residuals or --intervals";
  if (reason != nullptr) throw UsageError(reason, {.column = "--share-groups"});
}

void print_results(const std::vector<fit::FittedModel>& fits,
                   const std::vector<Resampling>& resampling,
                   const std::vector<std::string>& recognized,
                   const CommonOptions& common) {
  if (common.json) return print_json(fits, resampling, recognized);
  print_tables(fits);
  print_resampling(fits, resampling);
}

/// The first process prints; the text of a large fit takes more memory than the fit.
void report(const std::vector<fit::FittedModel>& fits,
            const std::vector<Resampling>& resampling,
            const std::vector<std::string>& recognized,
            const CommonOptions& common) {
  if (Ranks::of_process().is_first()) print_results(fits, resampling, recognized, common);
  std::fflush(stdout);
  const bool any = std::ranges::any_of(
      fits, [](const fit::FittedModel& fit) { return fit.convergence.converged(); });
  if (!any) {
    throw NoConvergedFit(fits.size() == 1 ? fits.front().convergence.verdict()
                                          : "no model converged");
  }
}

void run(const CLI::App& command, FitArguments arguments) {
  arguments.has_intervals = command.count("--intervals") > 0;
  // Structural indices in it are computed from all rows first.
  arguments.where = std::exchange(arguments.reading.rows.where, "");
  arguments.resampling.cross_validates = command.count("--cross-validate") > 0;
  refuse_idle_options(command, arguments);
  refuse_same_files({{"DATA.csv", arguments.data}},
                    {{"--residuals", arguments.resampling.residuals}});
  require_table_output(arguments.resampling.residuals);
  if (arguments.texts.formula.empty() == arguments.models.empty()) {
    throw UsageError("give either --formula or --model");
  }
  const study::Catalogue catalogue = study::Catalogue::load(data_directory() / "models");
  const auto models = chosen_models(catalogue, arguments.models);
  if (arguments.shares_groups) {
    refuse_with_shared_groups(arguments);
    std::vector<std::string> recognized;
    const std::vector<fit::FittedModel> fits{fit_of_shared(arguments, models, recognized)};
    return report(fits, {{}}, recognized, arguments.common);
  }
  const study::ReadTable read = read_data(arguments, models);
  const data::Table& table = read.table;
  const std::vector<Task> tasks = tasks_of(arguments, models, table);
  const std::vector<fit::FittedModel> fits = fit_all(tasks, table, arguments);
  std::vector<fit::FitModelOptions> options;
  options.reserve(tasks.size());
  for (const Task& task : tasks) options.push_back(task.options);
  const std::vector<Resampling> resampling =
      resample(fits, options, table, arguments.resampling, arguments.common);
  note_on_folds(resampling, arguments);
  write_residuals(fits, table, arguments.resampling);
  report(fits, resampling, read.recognized, arguments.common);
}

void add_model_options(CLI::App& command, FitArguments& arguments) {
  const std::string model = "Model";
  const std::string fit = "Fit";
  command
      .add_option(
          "--model",
          arguments.models,
          "Model of the catalogue, such as M4, or all:h for all models of a response; repeatable")
      ->type_name("ID")
      ->allow_extra_args(false)
      ->group(model);
  each_setting(arguments.texts, SettingOptions(command, model));
  each_setting(arguments.options, SettingOptions(command, fit));
  command.add_flag("--trace", arguments.trace, "Show the iterations on stderr")->group(fit);
  command
      .add_flag("--share-groups",
                arguments.shares_groups,
                "Each process of mpirun reads the data of its own groups only, for foce, focei, "
                "laplace and agq (docs/large-inventories.md)")
      ->group(fit);
}

}  // namespace

void add_fit_command(CLI::App& program) {
  const auto arguments = std::make_shared<FitArguments>();
  CLI::App& command =
      *program.add_subcommand("fit", "Fit models by least squares or with mixed effects");
  command
      .add_option(
          "data", arguments->data, "Table with a header: a CSV file, workbook, layer or database")
      ->type_name("DATA.csv")
      ->required();
  add_layer_options(command, arguments->table);
  add_model_options(command, *arguments);
  each_setting(arguments->intervals, SettingOptions(command, "Intervals"));
  command.get_option("--intervals")->default_str("");  // without it there are none
  add_resampling_options(command, arguments->resampling);
  add_reading_options(
      command, arguments->reading, {"columns", "missing", "fill_down", "trust_units"});
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit fit examples/fir-mixed/inventory.csv --model M4 --random \"a + b | plot\" "
              "--variance power --where 'species == \"SM\"'");
  command.callback([arguments, &command] { run(command, *arguments); });
}

}  // namespace silvafit::cli
