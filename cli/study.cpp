// SPDX-License-Identifier: MIT
// silvafit study: models, tables, predictions and a report from an inventory.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "command.hpp"
#include "help.hpp"
#include "output_files.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/base/ranks.hpp"
#include "silvafit/study/setting_list.hpp"
#include "silvafit/study/study_configuration.hpp"
#include "silvafit/study/study_files.hpp"
#include "silvafit/study/whole_study.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

struct StudyArguments {
  std::string command_line{};  ///< as the report shows it
  std::string inventory{};
  study::StudyConfiguration settings{};
  std::string out{};
  std::string workbook{};  ///< file for all tables, or for the trees as a layer
  std::string criterion = "level";
  std::string configuration{};
  std::string initial{};  ///< output file for a configuration with the default settings
  TableArguments table{};
  source::TableChoice plots{};
  CommonOptions common{};
};

/// One criterion for all levels; likelihood-ratio tests are then only shown, unless the command
/// line requires them.
void apply_criterion(const CLI::App& command,
                     const std::string& text,
                     study::StudyOptions& options) {
  if (text == "level") return;
  const study::Criterion all = value_of<study::Criterion>(text, "criterion");
  options.criteria = {.base = all, .covariates = all, .random = all, .variance = all};
  if (is_given(command, "tests")) return;
  options.needs_tests = false;
  if (!is_given(command, "significance")) options.significance = study::StudyOptions().significance;
}

/// The settings of the file, except those given on the command line.
void apply_configuration(const CLI::App& command, StudyArguments& arguments) {
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  const auto has_priority = [&command](std::string_view key) {
    // A window of the command line replaces a circle of the file, and vice versa.
    if (key == "window" || key == "circle") {
      return is_given(command, "window") || is_given(command, "circle");
    }
    return is_given(command, key);
  };
  arguments.settings = study::read_study_configuration(
      arguments.configuration,
      &catalogue,
      {.settings = std::move(arguments.settings), .is_given = has_priority});
}

/// Applies --config and --criterion; options of the command line have priority over the file.
void apply_settings(const CLI::App& command, StudyArguments& arguments) {
  if (!arguments.configuration.empty()) apply_configuration(command, arguments);
  apply_criterion(command, arguments.criterion, arguments.settings.study);
}

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.1f} %", 100.0 * share) : "-";
}

std::string or_dash(const std::string& text) { return text.empty() ? "-" : text; }

/// The base model by its id, or by its formula if it is not in the catalogue.
std::string base_model(const study::ResponseStudy& result) {
  if (!result.ols) return "-";
  const fit::FittedModel& fit = result.ols->fit;
  return fit.model.empty() ? fit.specification.formula.text : fit.model;
}

/// The first lines: sound models, and the reasons against doubtful ones.
void print_soundness(const study::Study& study) {
  if (study.results.empty()) return;
  const auto sound = std::ranges::count_if(study.results, &study::ResponseStudy::is_sound);
  print_text("Sound: {} of {} final models.\n", sound, study.results.size());
  for (const study::ResponseStudy& result : study.results) {
    if (result.is_sound()) continue;
    std::vector<std::string> reasons = result.doubts;
    if (!result.converged()) reasons.insert(reasons.begin(), result.verdict());
    const std::string text = fmt::format("{}", fmt::join(reasons, " "));
    print_text("Doubtful: {} {}. {}\n", result.species, result.response, with_options(text));
  }
  print_text("\n");
}

/// What should be known about the models, and why the best candidates of a level were not chosen,
/// one line each.
void print_remarks(const study::Study& study) {
  bool is_first = true;
  for (const study::ResponseStudy& result : study.results) {
    for (const std::string& sentence : result.remarks()) {
      if (is_first) print_text("\n");
      is_first = false;
      print_text("{} {}: {}\n", result.species, result.response, with_options(sentence));
    }
  }
}

/// The last column: whether a model is sound.
const char* mark_of(const study::ResponseStudy& result) {
  if (!result.converged()) return result.ols && !result.nlme ? "no mixed model" : "not converged";
  return result.is_sound() ? "" : "doubtful";
}

void print_table(const study::Study& study) {
  std::size_t width = 4;
  for (const study::ResponseStudy& result : study.results) {
    width = std::max(width, base_model(result).size());
  }
  print_text("{:<10} {:<4} {:>5}  {:<{}}  {:<18}  {:<18}  {:<19}  {:>8}  {:>8}  {}\n",
             "species",
             "",
             "trees",
             "base",
             width,
             "covariates",
             "random effects",
             "variance",
             "R2 OLS",
             "R2 NLME",
             "");
  for (const study::ResponseStudy& result : study.results) {
    const double ols = result.ols ? result.ols->fit.population.r2 : NAN;
    const double nlme = result.nlme ? result.nlme->fit.conditional.r2 : NAN;
    print_text("{:<10} {:<4} {:>5}  {:<{}}  {:<18}  {:<18}  {:<19}  {:>8}  {:>8}  {}\n",
               result.species,
               result.response,
               result.rows.size(),
               base_model(result),
               width,
               or_dash(result.chosen_terms(&study::ResponseStudy::covariates)),
               or_dash(result.chosen_terms(&study::ResponseStudy::random)),
               result.nlme ? result.nlme->fit.variance.function().text() : "-",
               percent(ols),
               percent(nlme),
               mark_of(result));
  }
  print_text(
      "\nbase: a curve of `silvafit models`. covariates: what its coefficients depend on; b ~ 1 + "
      "C "
      "is b = b0 + b1*C.\n"
      "random effects: coefficients that vary by {}. R2: of one curve for all (OLS), and of a "
      "curve "
      "for each {} (NLME).\n",
      study.options.group,
      study.options.group);
}

/// `--init`: writes a configuration with the default settings.
void write_initial_configuration(const StudyArguments& arguments) {
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  const std::filesystem::path file = arguments.initial;
  const TreeTable trees = open_trees(arguments.inventory, arguments.table, arguments.common);
  Progress progress(arguments.common);
  const std::string text =
      study::study_configuration_for(trees.table,
                                     catalogue,
                                     study::seen_from(file.parent_path(), arguments.settings),
                                     callbacks(arguments.common, progress));
  if (is_there(file)) {
    throw InputError("the file already exists; remove it, or choose another name",
                     {.file = arguments.initial});
  }
  write_file(file, text);
  say(arguments.common,
      fmt::format("Edit {0}, then: silvafit study {1} --config {0} --out DIR",
                  arguments.initial,
                  arguments.inventory));
  if (arguments.common.json) {
    print_json_value({{"schema", "silvafit-study-settings/1"},
                      {"silvafit", version()},
                      {"inventory", arguments.inventory},
                      {"settings", arguments.initial}});
  }
}

/// \param coordinates  gets the reference system of the trees' positions
study::StudyRecord make_record(const StudyArguments& arguments,
                               const study::Catalogue& catalogue,
                               std::optional<source::CoordinateSystem>& coordinates) {
  study::StudyConfiguration settings = arguments.settings;
  const TreeTable trees =
      open_inventory(arguments.inventory, arguments.table, settings.units, arguments.common);
  coordinates = trees.coordinates;
  open_plots(arguments.plots, trees, arguments.common, settings.sampling);
  Progress progress(arguments.common);
  return study::whole_study(
      trees.table, catalogue, settings, callbacks(arguments.common, progress));
}

/// `--workbook`: each table as a sheet, or the trees with their predictions as a layer.
void write_workbook(const StudyArguments& arguments,
                    const study::StudyRecord& record,
                    const std::optional<source::CoordinateSystem>& coordinates) {
  const std::string& file = arguments.workbook;
  if (file.empty()) return;
  if (source::has_geometries(file)) {
    auto plots =
        record.units ? plot_layer(record.inventory.inventory, record.units->windows) : std::nullopt;
    write_trees(file,
                study::predictions_of(record, study::library_of(record)),
                std::move(plots),
                coordinates,
                arguments.common);
  } else {
    if (Ranks::of_process().is_first()) write_sheets_of_folder(file, arguments.out);
  }
}

/// \param page  template of the report
void run_whole_study(const StudyArguments& arguments, const std::filesystem::path& page) {
  const auto start = std::chrono::steady_clock::now();
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  std::optional<source::CoordinateSystem> coordinates;
  study::StudyRecord record = make_record(arguments, catalogue, coordinates);
  record.command = arguments.command_line;
  const std::filesystem::path folder = arguments.out;
  study::write_study(record, catalogue, page, folder);
  write_workbook(arguments, record, coordinates);

  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (arguments.common.json) {
    print_json_value(study::json_of(record, folder));
  } else {
    print_soundness(record.study);
    print_table(record.study);
    print_remarks(record.study);
    print_text("\n{} fits in {:.1f} s, {:.0f} a second. The report: {}\n",
               record.study.fit_count(),
               seconds.count(),
               static_cast<double>(record.study.fit_count()) / seconds.count(),
               (folder / "report.html").string());
  }
  for (const study::ResponseStudy& result : record.study.results) {
    if (result.converged()) return;
  }
  throw NoConvergedFit(record.study.fit_count() == 0 ? "there was nothing to fit; see the notes"
                                                     : "no model converged; see the report");
}

void run(const CLI::App& command, StudyArguments& arguments) {
  const bool needs_folder = arguments.initial.empty();
  if (needs_folder && arguments.out.empty()) {
    throw UsageError("--out DIR is missing: the folder for the results");
  }
  apply_settings(command, arguments);
  arguments.settings.study.threads = arguments.common.threads;
  if (!needs_folder) return write_initial_configuration(arguments);
  study::refuse_idle(arguments.settings, given_options(command));
  refuse_same_files({{"INVENTORY.csv", arguments.inventory},
                     {"--window", arguments.settings.units.window},
                     {"--plots", arguments.settings.sampling.plots_file},
                     {"--config", arguments.configuration}},
                    files_in({"--out", arguments.out},
                             {"library.json",
                              "indices.csv",
                              "predictions.csv",
                              "excluded.csv",
                              "report.html",
                              "run.json"}));
  // Checked before the fits, which take time.
  if (!arguments.workbook.empty() && !is_layer_output(arguments.workbook)) {
    throw UsageError("the ending must be .xlsx, .ods, .gpkg or .fgb", {.column = "--workbook"});
  }
  require_table_output(arguments.workbook);
  const std::filesystem::path page = bundled_page("report.html");
  const ResultFolder folder(arguments.out);
  run_whole_study(arguments, page);
}

}  // namespace

void add_study_command(CLI::App& program, std::string command_line) {
  auto arguments = std::make_shared<StudyArguments>();
  arguments->command_line = std::move(command_line);
  CLI::App* command = program.add_subcommand(
      "study", "Run all steps: indices, models at three levels, library, predictions, report");
  add_inventory_options(
      *command, arguments->inventory, arguments->settings.reading, arguments->table);
  add_output_option(*command, "--out", arguments->out, "Folder for the results", "DIR");
  add_output_option(*command,
                    "--workbook",
                    arguments->workbook,
                    "Also write the tables as sheets of this workbook (.xlsx, .ods), or the trees "
                    "and plots as layers (.gpkg, .fgb)");
  command
      ->add_option("--config",
                   arguments->configuration,
                   "Settings of the study; options on the command line take precedence")
      ->type_name("STUDY.json");
  command
      ->add_option("--init",
                   arguments->initial,
                   "Write a commented settings file for this inventory, and stop")
      ->type_name("STUDY.json");
  const std::string section = "Models";
  each_setting(arguments->settings.study, SettingOptions(*command, section));
  command
      ->add_option(
          "--criterion",
          arguments->criterion,
          "Criterion for all levels, with tests only if --tests requires them: aic, aicc, "
          "bic or cv (prediction error for plots left out); default: each level has its own")
      ->check(CLI::IsMember({"level", "aic", "aicc", "bic", "cv"}))
      ->capture_default_str()
      ->group(section);
  add_sampling_options(*command, arguments->settings.sampling, arguments->plots);
  add_unit_options(*command, arguments->settings.units);
  add_window_layer_option(*command, arguments->table);
  add_common_options(*command, arguments->common);
  add_example(*command, "silvafit study examples/fir-mixed/inventory.csv --out build/demo");
  command->callback([arguments, command] { run(*command, *arguments); });
}

}  // namespace silvafit::cli
