// SPDX-License-Identifier: MIT
// silvafit study: the whole way from an inventory to models, tables, predictions and a report.
#include "silvafit/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "name_list.hpp"
#include "output_files.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "silvafit/study/study_files.hpp"
#include "standard_output.hpp"
#include "study_arguments.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

using Decisions = std::vector<std::pair<std::string, std::string>>;

/// A criterion in a sentence.
std::string named(study::Criterion criterion) {
  switch (criterion) {
    case study::Criterion::kAic:
      return "AIC";
    case study::Criterion::kAicc:
      return "AICc";
    case study::Criterion::kBic:
      return "BIC";
    case study::Criterion::kCrossValidation:
      break;
  }
  return "prediction error for plots left out (10 folds)";
}

/// "2 AIC", or one standard error of an error.
std::string distance(study::Criterion criterion, double equally_good) {
  return criterion == study::Criterion::kCrossValidation
             ? "one standard error"
             : fmt::format("{:g} {}", equally_good, named(criterion));
}

void add_level_decisions(const study::StudyRecord& record, Decisions& decisions) {
  const study::StudyOptions& options = record.study.options;
  const study::LevelCriteria& criteria = options.criteria;
  const std::string test = options.needs_tests ? fmt::format(", likelihood-ratio test at {:g} %",
                                                             100.0 * options.significance)
                                               : std::string();
  const auto best = [&](study::Criterion criterion) {
    return options.parsimonious ? fmt::format("fewest parameters within {} of the best",
                                              distance(criterion, options.equally_good))
                                : fmt::format("lowest {}", named(criterion));
  };
  const auto got_to = [&](std::vector<study::Candidate> study::ResponseStudy::*level) {
    return std::ranges::any_of(record.study.results, [level](const study::ResponseStudy& result) {
      return !(result.*level).empty();
    });
  };
  decisions.emplace_back("Level 1",
                         got_to(&study::ResponseStudy::base)
                             ? fmt::format("fewest parameters within {} of the best base model",
                                           distance(criteria.base, options.equally_good))
                             : "skipped: there was nothing to fit");
  decisions.emplace_back(
      "Level 2",
      got_to(&study::ResponseStudy::covariates)
          ? fmt::format(
                "lowest {} of covariate subsets on {}{}",
                named(criteria.covariates),
                options.covariate_parameters > 1 ? "one or two parameters" : "one parameter",
                test)
          : "skipped: no model reached this level, or there are no covariates (structural units "
            "need positions)");
  if (!got_to(&study::ResponseStudy::random)) {
    decisions.emplace_back("Level 3", "skipped: no model reached this level");
    return;
  }
  decisions.emplace_back(
      "Level 3",
      fmt::format("Lindstrom-Bates, maximum likelihood; random effects of {} on up to {} "
                  "coefficients by {}, then variance function by {}{}",
                  options.group,
                  options.maximum_random_effects,
                  best(criteria.random),
                  best(criteria.variance),
                  test));
}

Decisions decisions_of(const StudyArguments& arguments, const study::StudyRecord& record) {
  Decisions decisions;
  if (record.units) {
    const std::string window =
        arguments.units.window.empty()
            ? fmt::format("convex hull of {}",
                          arguments.units.per == "stand" ? "the stand" : "each plot")
            : std::filesystem::path(arguments.units.window).filename().string();
    decisions.emplace_back("Window", window);
    decisions.emplace_back("Edge correction",
                           arguments.units.edge == "buffer"
                               ? fmt::format("buffer of {} m", arguments.units.buffer_m)
                               : arguments.units.edge);
    decisions.emplace_back("Structural units",
                           fmt::format("{} nearest neighbors, searched in the {}",
                                       arguments.units.neighbors,
                                       arguments.units.per));
  }
  add_level_decisions(record, decisions);
  return decisions;
}

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.1f} %", 100.0 * share) : "-";
}

std::string chosen_terms(const std::vector<study::Candidate>& candidates, const char* joint) {
  for (const study::Candidate& candidate : candidates) {
    if (candidate.chosen) return fmt::format("{}", fmt::join(candidate.terms, joint));
  }
  return "";
}

std::string or_dash(const std::string& text) { return text.empty() ? "-" : text; }

/// The base model by its id, or by its formula where it is one's own.
std::string base_model(const study::ResponseStudy& result) {
  if (!result.ols) return "-";
  const fit::FittedModel& fit = result.ols->fit;
  return fit.model.empty() ? fit.specification.formula.text : fit.model;
}

/// The first lines: which models to rely on, and why not on the others.
void print_soundness(const study::Study& study) {
  if (study.results.empty()) return;
  const auto sound = std::ranges::count_if(study.results, &study::ResponseStudy::is_sound);
  print_text("Sound: {} of {} final models.\n", sound, study.results.size());
  for (const study::ResponseStudy& result : study.results) {
    if (result.is_sound()) continue;
    std::vector<std::string> reasons = result.doubts;
    if (!result.converged()) reasons.insert(reasons.begin(), result.verdict());
    print_text("Doubtful: {} {}. {}\n", result.species, result.response, fmt::join(reasons, " "));
  }
  print_text("\n");
}

/// Why the best candidates of a level were not chosen, one line each.
void print_passed_over(const study::Study& study) {
  bool is_first = true;
  for (const study::ResponseStudy& result : study.results) {
    for (const std::string& sentence : result.passed_over()) {
      if (is_first) print_text("\n");
      is_first = false;
      print_text("{} {}: {}\n", result.species, result.response, sentence);
    }
  }
}

/// The last column: whether a model can be relied on.
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
               or_dash(chosen_terms(result.covariates, "; ")),
               or_dash(chosen_terms(result.random, " + ")),
               result.nlme ? result.nlme->fit.variance.function().text() : "-",
               percent(ols),
               percent(nlme),
               mark_of(result));
  }
}

ordered_json left_out(const study::ResponseStudy& result) {
  if (!result.left_out) return nullptr;
  return {{"rmse_ols", number_or_null(result.left_out->rmse_ols)},
          {"rmse_covariates", number_or_null(result.left_out->rmse_covariates)},
          {"rmse_nlme", number_or_null(result.left_out->rmse_nlme)},
          {"worse", result.left_out->is_worse}};
}

void print_json(const study::StudyRecord& record, const std::filesystem::path& folder) {
  ordered_json summary{{"schema", "silvafit-study/1"},
                       {"silvafit", version()},
                       {"out", folder.string()},
                       {"report", (folder / "report.html").string()},
                       {"fits", record.study.fit_count()},
                       {"recognized", record.inventory.recognized},
                       {"notes", record.study.notes},
                       {"results", ordered_json::array()}};
  for (const study::ResponseStudy& result : record.study.results) {
    summary["results"].push_back(
        {{"species", result.species},
         {"response", result.response},
         {"n", result.rows.size()},
         {"model", text_or_null(result.ols ? result.ols->fit.model : "")},
         {"formula", text_or_null(result.ols ? result.ols->fit.specification.formula.text : "")},
         {"covariates", chosen_terms(result.covariates, "; ")},
         {"random", chosen_terms(result.random, " + ")},
         {"variance", result.nlme ? result.nlme->fit.variance.function().text() : ""},
         {"r2_ols", number_or_null(result.ols ? result.ols->fit.population.r2 : NAN)},
         {"r2_nlme", number_or_null(result.nlme ? result.nlme->fit.conditional.r2 : NAN)},
         {"converged", result.converged()},
         {"verdict", result.verdict()},
         {"sound", result.is_sound()},
         {"doubts", result.doubts},
         {"passed_over", result.passed_over()},
         {"left_out", left_out(result)}});
  }
  print_json_value(summary);
}

/// Columns of the file that a study reads besides those of an inventory: covariates, the group, and
/// what own formulas name. Names that are no column are parameters there.
std::vector<std::string> other_columns(const StudyArguments& arguments) {
  constexpr std::size_t kMostCovariates = 8;
  if (arguments.study.covariates.size() > kMostCovariates) {
    throw UsageError(fmt::format("{} covariates have too many subsets; the maximum is {}",
                                 arguments.study.covariates.size(),
                                 kMostCovariates),
                     {.column = "--covariates"});
  }
  std::vector<std::string> names;
  for (const std::string& name : arguments.study.covariates) {
    if (!study::is_structure_name(name)) names.push_back(name);
  }
  if (arguments.study.group != "plot") names.push_back(arguments.study.group);
  for (const std::string& text : arguments.study.variance_functions) {
    for (const fit::VarianceFactor& factor : fit::parse_variance_function(text).factors) {
      for (const std::string& name : {factor.column, factor.stratum}) {
        if (!name.empty() && !study::is_structure_name(name)) names.push_back(name);
      }
    }
  }
  return names;
}

/// What own candidates and responses may read: with them, every column of the file is kept.
bool has_own_candidates(const study::StudyOptions& options) {
  const auto is_own = [](const std::string& text) { return text.find('~') != std::string::npos; };
  return std::ranges::any_of(options.candidates, [&](const auto& entry) {
    return std::ranges::any_of(entry.second, is_own);
  });
}

/// The further indices asked for, and those among the covariates.
std::vector<stand::FurtherIndex> further_indices_of(const StudyArguments& arguments) {
  std::vector<stand::FurtherIndex> indices = further_indices(arguments.units);
  for (const std::string& name : arguments.study.covariates) {
    if (const auto index = stand::further_index_named(name)) indices.push_back(*index);
  }
  return indices;
}

stand::StructuralUnitOptions options_of_units(const StudyArguments& arguments) {
  stand::StructuralUnitOptions options = unit_options(arguments.units, arguments.common);
  options.further = further_indices_of(arguments);
  return options;
}

study::StudyRecord make_record(const StudyArguments& arguments) {
  study::StudyRecord record{.version = version(),
                            .command = command_line(),
                            .settings = settings_of(arguments, arguments.out)};
  record.inventory = read_inventory(
      arguments.inventory,
      {.keep = other_columns(arguments), .keep_all = has_own_candidates(arguments.study)},
      arguments.common);
  const bool has_positions = record.inventory.inventory.has_coordinates();
  const stand::StructuralUnitOptions options = options_of_units(arguments);
  if (has_positions) {
    record.units = stand::structural_units(record.inventory.inventory, options);
    for (const std::string& note : record.units->notes) say(arguments.common, "note: " + note);
  }
  record.table = study::inventory_table(record.inventory.inventory, record.units);
  if (has_positions) {
    // Without crown widths there is no C, and computing the units again would find none either.
    const auto& covariates = arguments.study.covariates;
    const bool wants_crowding = std::ranges::find(covariates, "C") != covariates.end();
    if (wants_crowding && !record.table.has("C")) {
      record.table.set("C", std::vector<double>(record.table.rows(), data::kMissing));
    }
    const auto notes = study::add_structure_columns(
        study::structure_names_in(covariates, record.table), record.table, options);
    for (const std::string& note : notes) say(arguments.common, "note: " + note);
  }
  return record;
}

/// `--init`: a configuration to start from.
void initialise(const StudyArguments& arguments) {
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  const stand::CheckedInventory inventory =
      read_inventory(arguments.inventory, {.keep_all = true}, arguments.common);
  if (is_there(arguments.initial)) {
    throw InputError("the file already exists; remove it, or choose another name",
                     {.file = arguments.initial});
  }
  write_file(arguments.initial,
             study::study_configuration_for(
                 stand::to_table(inventory.inventory),
                 catalogue,
                 settings_of(arguments, std::filesystem::path(arguments.initial).parent_path())));
  say(arguments.common,
      fmt::format("Edit {0}, then: silvafit study {1} --config {0} --out DIR",
                  arguments.initial,
                  arguments.inventory.path));
  if (arguments.common.json) {
    print_json_value({{"schema", "silvafit-study-settings/1"},
                      {"silvafit", version()},
                      {"inventory", arguments.inventory.path},
                      {"settings", arguments.initial}});
  }
}

/// \param page  that becomes the report
void run_whole_study(StudyArguments& arguments, const std::filesystem::path& page) {
  const auto start = std::chrono::steady_clock::now();
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  study::StudyRecord record = make_record(arguments);
  arguments.study.threads = arguments.common.threads;
  {
    Progress progress(arguments.common);
    record.study = study::run_study(
        record.table,
        catalogue,
        arguments.study,
        [&progress](const std::string& stage, std::size_t done, std::size_t total) {
          progress.show(stage, done, total);
        });
  }
  for (const std::string& note : record.study.notes) say(arguments.common, "note: " + note);
  record.decisions = decisions_of(arguments, record);
  const std::filesystem::path folder = arguments.out;
  study::write_study(record, catalogue, page, folder);

  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (arguments.common.json) {
    print_json(record, folder);
  } else {
    print_soundness(record.study);
    print_table(record.study);
    print_passed_over(record.study);
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
  if (!needs_folder) return initialise(arguments);
  refuse_idle_unit_options(command, arguments.units, further_indices_of(arguments));
  refuse_same_files({{"INVENTORY.csv", arguments.inventory.path},
                     {"--window", arguments.units.window},
                     {"--config", arguments.configuration}},
                    files_in({"--out", arguments.out},
                             {"library.json",
                              "indices.csv",
                              "predictions.csv",
                              "excluded.csv",
                              "report.html",
                              "run.json"}));
  // Before the time that the fits take.
  const std::filesystem::path page = bundled_page("report.html");
  const ResultFolder folder(arguments.out);
  run_whole_study(arguments, page);
}

}  // namespace

void add_study_command(CLI::App& program) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* command = program.add_subcommand(
      "study", "Run all steps: indices, models at three levels, library, predictions, report");
  add_inventory_options(*command, arguments->inventory);
  command->add_option("--out", arguments->out, "Folder for the results")->type_name("DIR");
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
  add_names_option(*command,
                   "--species",
                   arguments->study.species,
                   "Species to study (default: all with enough trees)");
  command->add_option("--responses", arguments->study.responses, "Responses to model")
      ->delimiter(',')
      ->capture_default_str();
  command
      ->add_option("--covariates",
                   arguments->study.covariates,
                   "Covariates of level 2: W, M, U, C, CO, T, Hegyi, BAL, CCF, stems_per_ha, "
                   "basal_area_per_ha, quadratic_mean_dbh, dominant_height, or columns of the file")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--group", arguments->study.group, "Column of the random effects")
      ->capture_default_str();
  command
      ->add_option("--criterion",
                   arguments->criterion,
                   "Criterion for all levels, without tests: aic, aicc, bic or cv (prediction "
                   "error for plots left out); default: each level has its own")
      ->check(CLI::IsMember({"level", "aic", "aicc", "bic", "cv"}))
      ->capture_default_str();
  command
      ->add_option("--minimum-trees",
                   arguments->study.minimum_trees,
                   "Minimum number of measured trees of a species")
      ->capture_default_str();
  add_unit_options(*command, arguments->units);
  add_common_options(*command, arguments->common);
  add_example(*command, "silvafit study examples/fir-mixed/inventory.csv --out build/demo");
  command->callback([arguments, command] { run(*command, *arguments); });
}

}  // namespace silvafit::cli
