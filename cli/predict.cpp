// SPDX-License-Identifier: MIT
// `silvafit predict`: predictions of a model library for new trees.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "csv_with_columns.hpp"
#include "inventory_options.hpp"
#include "library_named.hpp"
#include "output_files.hpp"
#include "prediction_digits.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/predict_responses.hpp"
#include "standard_output.hpp"
#include "tree_table.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct PredictArguments {
  CommonOptions common{};
  std::vector<std::string> files{};
  std::string library{};
  std::string data{};
  std::string level = "population";
  std::string new_groups = "population";
  std::string seen_groups = "fitted";
  double interval = 0.0;  ///< 0: none
  std::string interval_kind = "prediction";
  bool standard_errors = false;
  std::string role = "nlme";
  bool has_role = false;  ///< --role is given
  int digits = kPredictedDigits;
  std::string out{};
  std::vector<std::string> columns{};
  SheetArguments sheet{};
  bool trust_units = false;
};

const std::map<std::string, fit::Level> kLevels{{"population", fit::Level::kPopulation},
                                                {"conditional", fit::Level::kConditional},
                                                {"calibrated", fit::Level::kCalibrated},
                                                {"marginal", fit::Level::kMarginal}};
const std::map<std::string, fit::SeenGroups> kSeenGroups{{"fitted", fit::SeenGroups::kFitted},
                                                         {"new", fit::SeenGroups::kNew},
                                                         {"combined", fit::SeenGroups::kCombined}};
const std::map<std::string, fit::IntervalKind> kIntervalKinds{
    {"prediction", fit::IntervalKind::kPrediction}, {"confidence", fit::IntervalKind::kConfidence}};
const std::map<std::string, fit::NewGroups> kNewGroups{{"population", fit::NewGroups::kPopulation},
                                                       {"marginal", fit::NewGroups::kMarginal},
                                                       {"missing", fit::NewGroups::kMissing},
                                                       {"error", fit::NewGroups::kError}};

/// The columns of one response.
std::vector<std::pair<std::string, const std::vector<double>*>> columns_of(
    const study::PredictedResponse& prediction, bool standard_errors) {
  std::vector<std::pair<std::string, const std::vector<double>*>> result{
      {"_pred", &prediction.value}, {"_lower", &prediction.lower}, {"_upper", &prediction.upper}};
  if (standard_errors) result.emplace_back("_se", &prediction.standard_error);
  result.emplace_back("_trees", &prediction.trees);
  std::erase_if(result, [](const auto& column) { return column.second->empty(); });
  for (auto& [name, values] : result) name.insert(0, prediction.response);
  return result;
}

std::vector<std::string> names_of(const PredictArguments& arguments,
                                  const study::PredictedResponses& predictions) {
  std::vector<std::string> names;
  for (const auto& prediction : predictions.responses) {
    for (const auto& [name, values] : columns_of(prediction, arguments.standard_errors)) {
      names.push_back(name);
    }
  }
  names.emplace_back("flag");
  return names;
}

std::string field_of(const std::vector<double>& values,
                     std::size_t row,
                     const study::PredictedResponse& prediction,
                     int digits) {
  const double value = values[row];
  if (std::isnan(value)) return {};
  const bool is_fitted = &values == &prediction.trees && value == study::kFittedEffects;
  return is_fitted ? "fitted" : with_digits(value, digits);
}

void write_out(const PredictArguments& arguments, const study::PredictedResponses& predictions) {
  const auto fields = [&](std::size_t row) {
    std::vector<std::string> result;
    for (const auto& prediction : predictions.responses) {
      for (const auto& [name, values] : columns_of(prediction, arguments.standard_errors)) {
        result.push_back(field_of(*values, row, prediction, arguments.digits));
      }
    }
    result.push_back(predictions.flags[row]);
    return result;
  };
  write_with_columns(arguments.data,
                     arguments.out,
                     {.names = names_of(arguments, predictions),
                      .fields = fields,
                      .fill_down = arguments.sheet.fill_down,
                      .mapped = arguments.columns},
                     arguments.common);
}

ordered_json unused_json(const std::vector<study::UnusedModel>& models) {
  ordered_json list = ordered_json::array();
  for (const study::UnusedModel& model : models) {
    list.push_back({{"species", text_or_null(model.species)},
                    {"response", model.response},
                    {"model", model.name},
                    {"missing", model.missing},
                    {"instead", text_or_null(model.instead)}});
  }
  return list;
}

void print_summary(const PredictArguments& arguments,
                   const ReadTable& read,
                   const study::PredictedResponses& predictions) {
  ordered_json predicted = ordered_json::object();
  for (const auto& prediction : predictions.responses) {
    predicted[prediction.response] =
        std::ranges::count_if(prediction.value, [](double value) { return !std::isnan(value); });
  }
  std::map<std::string, std::size_t> flags;
  for (const std::string& flag : predictions.flags) {
    if (!flag.empty()) ++flags[flag];
  }
  const ordered_json result{
      {"schema", "silvafit-predict/1"},
      {"silvafit", version()},
      {"level", arguments.level},
      {"interval",
       arguments.interval > 0.0 ? ordered_json(arguments.interval) : ordered_json(nullptr)},
      {"interval_kind",
       arguments.interval > 0.0 ? ordered_json(arguments.interval_kind) : ordered_json(nullptr)},
      {"out", text_or_null(arguments.out)},
      {"n", predictions.flags.size()},
      {"predicted", std::move(predicted)},
      {"flags", flags},
      {"unused_models", unused_json(predictions.unused)},
      {"recognized", read.recognized},
      {"notes", predictions.notes}};
  print_json_value(result);
}

void refuse_known_columns(const PredictArguments& arguments,
                          const data::Table& table,
                          const study::PredictedResponses& predictions) {
  for (const std::string& name : names_of(arguments, predictions)) {
    if (table.has(name)) {
      throw InputError("the file already has this column; choose another name",
                       {.file = table.file(), .column = name});
    }
  }
}

/// Tells the library from the trees.
void sort_files(PredictArguments& arguments) {
  const std::size_t wanted = arguments.library.empty() ? 2 : 1;
  if (arguments.files.size() != wanted) {
    throw UsageError(wanted == 2
                         ? "give a library and a file of trees, such as library.json new.csv"
                         : "with --library, give only the file of trees");
  }
  if (wanted == 2) arguments.library = arguments.files.front();
  arguments.data = arguments.files.back();
}

/// Says which species of the file the library has no model of, and which it has.
void add_note_on_species(const study::ModelLibrary& library,
                         const data::Table& table,
                         std::vector<std::string>& notes) {
  std::set<std::string> known;
  for (const study::LibraryModel& model : library.models) known.insert(model.species);
  // A model without species is one of all trees.
  if (known.contains("") || !table.has("species")) return;
  const data::TextColumn species = table.labels("species");
  std::set<std::string> unknown;
  std::size_t trees = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (species.is_missing(row) || known.contains(std::string(species[row]))) continue;
    unknown.emplace(species[row]);
    ++trees;
  }
  if (unknown.empty()) return;
  const std::vector<std::string> names(unknown.begin(), unknown.end());
  notes.push_back(
      fmt::format("{} of species without a model in the library: {}; it has models for {}",
                  counted(trees, "tree is", "trees are"),
                  data::list_of(names),
                  data::list_of(std::vector(known.begin(), known.end()))));
}

/// How indices are computed: as in the study that the library is from.
stand::StructuralUnitOptions units_of(const study::ModelLibrary& library,
                                      const CommonOptions& common) {
  const auto settings = library.inventory.units.value_or(study::UnitSettings{});
  return unit_options(unit_arguments(settings), common);
}

void refuse_idle_options(const CLI::App& command, const PredictArguments& arguments) {
  const bool is_calibrated = arguments.level == "calibrated";
  refuse_idle(command,
              "--interval-kind",
              arguments.interval > 0.0 || arguments.standard_errors,
              "--interval or --standard-errors");
  refuse_idle(command,
              "--new-groups",
              is_calibrated || arguments.level == "conditional",
              "--level conditional or calibrated");
  refuse_idle(command, "--seen-groups", is_calibrated, "--level calibrated");
}

void run(const CLI::App& command, PredictArguments arguments) {
  refuse_idle_options(command, arguments);
  sort_files(arguments);
  refuse_same_files({{"LIBRARY.json", arguments.library}, {"NEW.csv", arguments.data}},
                    {{"--out", arguments.out}});
  const study::ModelLibrary library = library_named(arguments.library);
  const ReadTable read = read_model_table(arguments.data,
                                          {.entries = arguments.columns,
                                           .names = study::text_columns(library),
                                           .wanted = study::columns_read(library),
                                           .units = units_of(library, arguments.common),
                                           .sheet = arguments.sheet,
                                           .trust_units = arguments.trust_units},
                                          arguments.common);
  const data::Table& table = read.table;
  const study::Catalogue catalogue = study::Catalogue::load(data_directory() / "models");
  study::PredictedResponses predictions = study::predict_responses(
      library,
      table,
      {.level = kLevels.at(arguments.level),
       .new_groups = kNewGroups.at(arguments.new_groups),
       .seen_groups = kSeenGroups.at(arguments.seen_groups),
       .interval =
           arguments.interval > 0.0 ? std::optional<double>(arguments.interval) : std::nullopt,
       .interval_kind = kIntervalKinds.at(arguments.interval_kind),
       .standard_errors = arguments.standard_errors,
       .threads = arguments.common.threads,
       .role = arguments.role,
       .other_roles = !arguments.has_role,
       .catalogue = &catalogue});
  add_note_on_species(library, table, predictions.notes);
  for (const std::string& note : predictions.notes) say(arguments.common, "note: " + note);
  refuse_known_columns(arguments, table, predictions);
  write_out(arguments, predictions);
  if (arguments.common.json) print_summary(arguments, read, predictions);
}

void add_file_options(CLI::App& command, PredictArguments& arguments) {
  command
      .add_option("files",
                  arguments.files,
                  "The library (library.json of a study, the output of `silvafit fit --json`, or a "
                  "published library such as shanxia-2023) and a CSV file of trees; with --library "
                  "only the file of trees")
      ->type_name("LIBRARY.json NEW.csv")
      ->expected(1, 2)
      ->required();
  command.add_option("--library", arguments.library, "Library, instead of the first file")
      ->type_name("LIBRARY");
}

/// What is predicted for which groups.
void add_level_options(CLI::App& command, PredictArguments& arguments) {
  command
      .add_option("--level",
                  arguments.level,
                  "population: random effects 0 (b = 0); conditional: random effects of the fit; "
                  "calibrated: random effects from the trees measured in the file; marginal: mean "
                  "over all groups")
      ->check(CLI::IsMember({"population", "conditional", "calibrated", "marginal"}))
      ->capture_default_str();
  command
      .add_option("--new-groups",
                  arguments.new_groups,
                  "Conditional predictions for groups that are not in the fit, and calibrated "
                  "predictions for such groups without a measured tree")
      ->check(CLI::IsMember({"population", "marginal", "missing", "error"}))
      ->capture_default_str();
  command
      .add_option("--seen-groups",
                  arguments.seen_groups,
                  "Calibrated predictions for groups of the fit: use the random effects of the fit "
                  "(own), only the trees of the file (new), or both (combined)")
      ->check(CLI::IsMember({"fitted", "new", "combined"}))
      ->capture_default_str();
}

void add_interval_options(CLI::App& command, PredictArguments& arguments) {
  command
      .add_option(
          "--interval", arguments.interval, "Add interval limits with this coverage, such as 0.95")
      ->type_name("LEVEL")
      ->check(CLI::Range(1e-6, 0.999999));
  command
      .add_option("--interval-kind",
                  arguments.interval_kind,
                  "prediction: for the value of a tree; confidence: for the mean of such trees")
      ->check(CLI::IsMember({"prediction", "confidence"}))
      ->capture_default_str();
  command.add_flag("--standard-errors",
                   arguments.standard_errors,
                   "Add the standard error of the kind that --interval-kind selects");
}

}  // namespace

void add_predict_command(CLI::App& program) {
  const auto arguments = std::make_shared<PredictArguments>();
  CLI::App& command =
      *program.add_subcommand("predict", "Predict heights, crown bases and crown widths of trees");
  add_file_options(command, *arguments);
  add_level_options(command, *arguments);
  add_interval_options(command, *arguments);
  command
      .add_option(
          "--role",
          arguments->role,
          "Which models of a study to use; without this option, a model whose columns are not "
          "all in the file is replaced by the next simpler one")
      ->check(CLI::IsMember({"ols", "covariates", "nlme"}))
      ->capture_default_str();
  add_digits_option(command, arguments->digits);
  command
      .add_option(
          "--columns", arguments->columns, "Names or formulas of the columns, such as dbh=DBH_cm")
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
  add_sheet_options(command, arguments->sheet);
  add_trust_units_option(command, arguments->trust_units);
  command.add_option("--out", arguments->out, "CSV file to write (default: standard output)")
      ->type_name("FILE.csv");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit predict library.json new.csv --level calibrated --interval 0.95 --out "
              "predictions.csv");
  command.callback([arguments, &command] {
    arguments->has_role = command.count("--role") > 0;
    run(command, *arguments);
  });
}

}  // namespace silvafit::cli
