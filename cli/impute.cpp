// SPDX-License-Identifier: MIT
// `silvafit impute`: an inventory with what was not measured filled in.
#include "silvafit/study/impute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "csv_with_columns.hpp"
#include "output_files.hpp"
#include "prediction_digits.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/fit/fit_json.hpp"
#include "standard_output.hpp"
#include "tree_table.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct ImputeArguments {
  CommonOptions common{};
  study::ImputeOptions impute{};
  std::string data{};
  std::string out{};
  std::vector<std::string> columns{};
  int digits = kPredictedDigits;
  SheetArguments sheet{};
  bool trust_units = false;
};

std::vector<std::string> new_names(const ImputeArguments& arguments) {
  const std::string& response = arguments.impute.response;
  return {response + "_source", response + "_level", response + "_flag"};
}

ReadTable read_data(const ImputeArguments& arguments) {
  const std::string& group = arguments.impute.group;
  std::vector<std::string> labels{group.empty() ? "plot" : group, arguments.impute.by};
  if (!arguments.impute.random.empty() && arguments.impute.random != "none") {
    for (const auto& random : fit::parse_random_effects(arguments.impute.random)) {
      labels.push_back(random.group);
    }
  }
  std::vector<std::string> wanted = labels;
  wanted.insert(wanted.end(), {arguments.impute.response, "dbh"});
  ReadTable read = read_model_table(arguments.data,
                                    {.entries = arguments.columns,
                                     .names = std::move(labels),
                                     .wanted = std::move(wanted),
                                     .sheet = arguments.sheet,
                                     .trust_units = arguments.trust_units},
                                    arguments.common);
  const data::Table& table = read.table;
  for (const std::string& name : {arguments.impute.response, arguments.impute.by, group}) {
    if (name.empty() || table.has(name)) continue;
    throw InputError(data::no_such_column(name, table.names()), {.file = table.file()});
  }
  for (const std::string& name : new_names(arguments)) {
    if (!table.has(name)) continue;
    throw InputError("the file already has this column; choose another name",
                     {.file = table.file(), .column = name});
  }
  return read;
}

void write_out(const ImputeArguments& arguments, const study::Imputation& result) {
  const std::string& response = arguments.impute.response;
  const data::CsvReader reader(arguments.data);
  // With --columns, the response may have another name in the file, and gets a column of its own.
  const bool has_column = std::ranges::find(reader.header(), response) != reader.header().end();
  const auto value = [&](std::size_t row) {
    return std::isnan(result.value[row]) ? std::string()
                                         : with_digits(result.value[row], arguments.digits);
  };
  std::vector<std::string> names = new_names(arguments);
  if (!has_column) names.insert(names.begin(), response);
  const auto fields = [&](std::size_t row) {
    std::vector<std::string> texts{study::source_text(result.source[row]),
                                   study::level_text(result.level[row]),
                                   result.flag[row]};
    if (!has_column) texts.insert(texts.begin(), value(row));
    return texts;
  };
  const auto imputed = [&](std::size_t row) {
    return result.source[row] == study::ImputeSource::kImputed ? value(row) : std::string();
  };
  write_with_columns(arguments.data,
                     arguments.out,
                     {.names = names,
                      .fields = fields,
                      .replaced = response,
                      .replacement = imputed,
                      .fill_down = arguments.sheet.fill_down,
                      .mapped = arguments.columns},
                     arguments.common);
}

std::map<std::string, std::size_t> flag_counts(const study::Imputation& result) {
  std::map<std::string, std::size_t> counts;
  for (const std::string& flag : result.flag) {
    if (!flag.empty()) ++counts[flag];
  }
  return counts;
}

void print_json(const ImputeArguments& arguments,
                const ReadTable& read,
                const study::Imputation& result) {
  using study::ImputeLevel;
  using study::ImputeSource;
  ordered_json models = ordered_json::array();
  for (const study::ImputeModel& model : result.models) {
    models.push_back({{"label", text_or_null(model.label)}, {"fit", fit::json_of(model.fit)}});
  }
  const ordered_json summary{{"schema", "silvafit-impute/1"},
                             {"silvafit", version()},
                             {"response", arguments.impute.response},
                             {"out", text_or_null(arguments.out)},
                             {"n", result.value.size()},
                             {"measured", result.count(ImputeSource::kMeasured)},
                             {"imputed",
                              {{"plot", result.count(ImputeLevel::kPlot)},
                               {"stand", result.count(ImputeLevel::kStand)},
                               {"population", result.count(ImputeLevel::kPopulation)}}},
                             {"missing", result.count(ImputeSource::kMissing)},
                             {"flags", flag_counts(result)},
                             {"residual_added", arguments.impute.add_residual},
                             {"models", std::move(models)},
                             {"recognized", read.recognized},
                             {"notes", result.notes}};
  print_json_value(summary);
}

/// Such as ", random a | stand; a + b | plot"; empty without.
std::string random_text(const fit::ModelSpecification& specification) {
  if (!specification.random) return {};
  const auto text = [](const fit::RandomEffects& random) {
    return fmt::format("{} | {}", random.text(), random.group);
  };
  const auto& outer = specification.outer_random;
  return fmt::format(
      ", random {}{}", outer ? text(*outer) + "; " : "", text(*specification.random));
}

/// Whom a model is for, where there are several.
std::string label_of(const study::ImputeModel& model, const ImputeArguments& arguments) {
  if (arguments.impute.by.empty()) return "";
  return (model.label.empty() ? "all others" : model.label) + ": ";
}

/// What a person who reads the file wants to know of it.
void say_summary(const ImputeArguments& arguments, const study::Imputation& result) {
  using study::ImputeLevel;
  using study::ImputeSource;
  for (const std::string& note : result.notes) say(arguments.common, "note: " + note);
  for (const study::ImputeModel& model : result.models) {
    const fit::FittedModel& fit = model.fit;
    say(arguments.common,
        fmt::format("{}{}{}{}, variance {}, {} trees, conditional RMSE {:.4g}",
                    label_of(model, arguments),
                    fit.model.empty() ? "" : fit.model + " ",
                    fit.specification.formula.text,
                    random_text(fit.specification),
                    fit.specification.variance.text(),
                    fit.observations,
                    fit.conditional.rmse));
  }
  const std::size_t stand = result.count(ImputeLevel::kStand);
  say(arguments.common,
      fmt::format("{}: {} measured, {} imputed with the curve of their plot, {}{} with the "
                  "population curve, {} left empty",
                  arguments.impute.response,
                  result.count(ImputeSource::kMeasured),
                  result.count(ImputeLevel::kPlot),
                  stand > 0 ? fmt::format("{} with their stand, ", stand) : "",
                  result.count(ImputeLevel::kPopulation),
                  result.count(ImputeSource::kMissing)));
  for (const auto& [flag, count] : flag_counts(result)) {
    say(arguments.common, fmt::format("{}: {}", counted(count, "tree", "trees"), flag));
  }
}

void run(ImputeArguments& arguments) {
  refuse_same_files({{"INVENTORY.csv", arguments.data}}, {{"--out", arguments.out}});
  const ReadTable read = read_data(arguments);
  const data::Table& table = read.table;
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  arguments.impute.seed = arguments.common.seed;
  arguments.impute.threads = arguments.common.threads;
  const study::Imputation result = study::impute(table, catalogue, arguments.impute);
  write_out(arguments, result);
  say_summary(arguments, result);
  if (arguments.common.json) print_json(arguments, read, result);
}

void add_model_options(CLI::App& command, study::ImputeOptions& options) {
  command
      .add_option("--model",
                  options.models,
                  "Models of the catalogue, or all:h; the one with the lowest AIC is used "
                  "(default: Naslund's curve for h, else all models of the response); repeatable")
      ->type_name("ID")
      ->allow_extra_args(false);
  command.add_option("--formula", options.formula, "A formula instead of a model of the catalogue")
      ->type_name("FORMULA");
  command
      .add_option("--random",
                  options.random,
                  "Random effects such as \"a + b | plot\", or none (default: on the first two "
                  "coefficients, fewer if that does not converge)")
      ->type_name("EFFECTS");
  command.add_option(
      "--variance", options.variance, "Variance function, as in fit (default: power(dbh))");
  command.add_option("--method", options.method, "Method, as in fit (default: lb)");
}

}  // namespace

void add_impute_command(CLI::App& program) {
  const auto arguments = std::make_shared<ImputeArguments>();
  CLI::App& command = *program.add_subcommand(
      "impute", "Fill in heights, crown bases or crown widths that were not measured");
  command.add_option("data", arguments->data, "Trees: a CSV file with a header")
      ->type_name("INVENTORY.csv")
      ->required();
  study::ImputeOptions& options = arguments->impute;
  command.add_option("--response", options.response, "Column to fill in")->capture_default_str();
  add_model_options(command, options);
  command.add_option("--group", options.group, "Column of the plots (default: plot)");
  command.add_option(
      "--by", options.by, "Column whose values get separate models, such as species");
  command
      .add_option("--minimum-trees",
                  options.minimum_trees,
                  "Minimum number of measured trees for a separate model; the others share one "
                  "model for all trees")
      ->capture_default_str();
  command.add_flag("--add-residual",
                   options.add_residual,
                   "Add a random residual to imputed values, and random effects to plots without "
                   "measured trees");
  command
      .add_option(
          "--columns", arguments->columns, "Names or formulas of the columns, such as dbh=DBH_cm")
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
  add_digits_option(command, arguments->digits);
  add_sheet_options(command, arguments->sheet);
  add_trust_units_option(command, arguments->trust_units);
  command.add_option("--out", arguments->out, "CSV file to write (default: standard output)")
      ->type_name("FILE.csv");
  add_common_options(command, arguments->common);
  add_example(command, "silvafit impute inventory.csv --response h --by species --out filled.csv");
  command.callback([arguments, &command] {
    refuse_idle(command, "--minimum-trees", !arguments->impute.by.empty(), "--by");
    run(*arguments);
  });
}

}  // namespace silvafit::cli
