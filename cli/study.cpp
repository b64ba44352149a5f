// SPDX-License-Identifier: MIT
// silvafit study: the whole way from an inventory to models, tables, predictions and a report.
#include "silvafit/study/study.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "inventory_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/study/structure_columns.hpp"
#include "silvafit/study/study_files.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct Arguments {
  InventoryArguments inventory{};
  UnitArguments units{};
  study::StudyOptions study{};
  std::string out{};
  std::string criterion = "level";
  CommonOptions common{};
};

std::vector<std::pair<std::string, std::string>> decisions_of(const Arguments& arguments,
                                                              const study::StudyRecord& record) {
  std::vector<std::pair<std::string, std::string>> decisions;
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
  if (arguments.study.criterion != study::Criterion::kByLevel) {
    const bool is_error = arguments.study.criterion == study::Criterion::kCrossValidation;
    decisions.emplace_back(
        "Levels 1 to 3",
        is_error ? "lowest error of predictions for plots left out in 10 folds; level 3 calibrated "
                   "with 5 trees of each"
                 : fmt::format("lowest {}, without tests", arguments.criterion));
    return decisions;
  }
  decisions.emplace_back("Level 1", "fewest parameters within 2 AIC of the best base model");
  decisions.emplace_back(
      "Level 2",
      record.units
          ? "lowest BIC of covariate subsets on one parameter, likelihood-ratio test at 5 %"
          : "left out: no positions, so no structural units");
  decisions.emplace_back(
      "Level 3",
      fmt::format("Lindstrom-Bates, maximum likelihood; random effects of {} on up to {} "
                  "coefficients by lowest BIC, then variance function by lowest AIC "
                  "with likelihood-ratio test at 5 %",
                  record.study.options.group,
                  record.study.options.maximum_random_effects));
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

void print_table(const study::Study& study) {
  fmt::print("{:<10} {:<4} {:>5}  {:<4}  {:<18}  {:<18}  {:<19}  {:>8}  {:>8}  {}\n",
             "species",
             "",
             "trees",
             "base",
             "covariates",
             "random effects",
             "variance",
             "R2 OLS",
             "R2 NLME",
             "");
  for (const study::ResponseStudy& result : study.results) {
    const double ols = result.ols ? result.ols->fit.population.r2 : NAN;
    const double nlme = result.nlme ? result.nlme->fit.conditional.r2 : NAN;
    fmt::print("{:<10} {:<4} {:>5}  {:<4}  {:<18}  {:<18}  {:<19}  {:>8}  {:>8}  {}\n",
               result.species,
               result.response,
               result.rows.size(),
               result.ols ? result.ols->fit.model : "-",
               or_dash(chosen_terms(result.covariates, "; ")),
               or_dash(chosen_terms(result.random, " + ")),
               result.nlme ? result.nlme->fit.variance.function().text() : "-",
               percent(ols),
               percent(nlme),
               result.converged() ? "" : "not converged");
  }
}

void print_json(const study::StudyRecord& record, const std::filesystem::path& folder) {
  ordered_json summary{{"schema", "silvafit-study/1"},
                       {"silvafit", version()},
                       {"out", folder.string()},
                       {"report", (folder / "report.html").string()},
                       {"fits", record.study.fit_count()},
                       {"notes", record.study.notes},
                       {"results", ordered_json::array()}};
  for (const study::ResponseStudy& result : record.study.results) {
    const auto number = [](double value) {
      return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
    };
    summary["results"].push_back(
        {{"species", result.species},
         {"response", result.response},
         {"n", result.rows.size()},
         {"model", result.ols ? ordered_json(result.ols->fit.model) : ordered_json(nullptr)},
         {"covariates", chosen_terms(result.covariates, "; ")},
         {"random", chosen_terms(result.random, " + ")},
         {"variance", result.nlme ? result.nlme->fit.variance.function().text() : ""},
         {"r2_ols", number(result.ols ? result.ols->fit.population.r2 : NAN)},
         {"r2_nlme", number(result.nlme ? result.nlme->fit.conditional.r2 : NAN)},
         {"converged", result.converged()},
         {"verdict", result.verdict()}});
  }
  fmt::print("{}\n", summary.dump(2));
}

/// Covariates that the inventory itself must have.
std::vector<std::string> other_covariates(const Arguments& arguments) {
  constexpr std::size_t kMostCovariates = 8;
  if (arguments.study.covariates.size() > kMostCovariates) {
    throw UsageError(fmt::format("{} covariates have too many subsets; {} are the most",
                                 arguments.study.covariates.size(),
                                 kMostCovariates),
                     {.column = "--covariates"});
  }
  std::vector<std::string> names;
  for (const std::string& name : arguments.study.covariates) {
    if (!study::is_structure_name(name)) names.push_back(name);
  }
  return names;
}

/// The further indices among the covariates, and those asked for besides.
stand::StructuralUnitOptions options_of_units(const Arguments& arguments) {
  stand::StructuralUnitOptions options = unit_options(arguments.units, arguments.common);
  for (const std::string& name : arguments.study.covariates) {
    if (const auto further = stand::further_index_named(name)) options.further.push_back(*further);
  }
  return options;
}

study::StudyRecord make_record(const Arguments& arguments) {
  study::StudyRecord record{.version = version(), .command = command_line()};
  record.inventory =
      read_inventory(arguments.inventory, {.keep = other_covariates(arguments)}, arguments.common);
  const bool has_positions = record.inventory.inventory.has_coordinates();
  const stand::StructuralUnitOptions options = options_of_units(arguments);
  if (has_positions) {
    record.units = stand::structural_units(record.inventory.inventory, options);
    for (const std::string& note : record.units->notes) say(arguments.common, "note: " + note);
  }
  record.table = study::inventory_table(record.inventory.inventory, record.units);
  if (has_positions) {
    const auto notes = study::add_structure_columns(
        study::structure_names_in(arguments.study.covariates, record.table), record.table, options);
    for (const std::string& note : notes) say(arguments.common, "note: " + note);
  }
  return record;
}

void run(Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  study::StudyRecord record = make_record(arguments);
  arguments.study.threads = arguments.common.threads;
  arguments.study.criterion = study::parse_criterion(arguments.criterion);
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
  study::write_study(record, catalogue, data_directory() / "viewer" / "report.html", folder);

  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (arguments.common.json) {
    print_json(record, folder);
  } else {
    print_table(record.study);
    fmt::print("\n{} fits in {:.1f} s. The report: {}\n",
               record.study.fit_count(),
               seconds.count(),
               (folder / "report.html").string());
  }
  for (const study::ResponseStudy& result : record.study.results) {
    if (result.converged()) return;
  }
  throw NoConvergedFit("no model converged; the report says why");
}

}  // namespace

void add_study_command(CLI::App& program) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program.add_subcommand(
      "study", "The whole way: indices, models in three levels, library, predictions, report");
  add_inventory_options(*command, arguments->inventory);
  command->add_option("--out", arguments->out, "Folder for the results")->required();
  command
      ->add_option("--species",
                   arguments->study.species,
                   "Species to study (default: all with enough trees)")
      ->delimiter(',');
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
  command
      ->add_option("--criterion",
                   arguments->criterion,
                   "What the levels choose by: aic, aicc, bic, cv (cross-validated error), or each "
                   "level's own with its tests")
      ->check(CLI::IsMember({"level", "aic", "aicc", "bic", "cv"}))
      ->capture_default_str();
  command
      ->add_option("--minimum-trees",
                   arguments->study.minimum_trees,
                   "Fewest measured trees of a species that get models")
      ->capture_default_str();
  add_unit_options(*command, arguments->units);
  add_common_options(*command, arguments->common);
  add_example(*command, "silvafit study examples/fir-mixed/inventory.csv --out build/demo");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace silvafit::cli
