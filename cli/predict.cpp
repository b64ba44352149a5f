// SPDX-License-Identifier: MIT
// `silvafit predict`: predictions of a model library for new trees.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/study/predict_responses.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct PredictArguments {
  CommonOptions common{};
  std::string library{};
  std::string data{};
  std::string level = "population";
  std::string new_groups = "population";
  std::string role = "nlme";
  std::string out{};
  std::vector<std::string> columns{};
};

const std::map<std::string, fit::Level> kLevels{{"population", fit::Level::kPopulation},
                                                {"conditional", fit::Level::kConditional}};
const std::map<std::string, fit::NewGroups> kNewGroups{{"population", fit::NewGroups::kPopulation},
                                                       {"missing", fit::NewGroups::kMissing},
                                                       {"error", fit::NewGroups::kError}};

std::vector<std::string> names_of(const study::PredictedResponses& predictions) {
  std::vector<std::string> names;
  for (const auto& prediction : predictions.responses)
    names.push_back(prediction.response + "_pred");
  names.emplace_back("flag");
  return names;
}

/// The file as it is, byte for byte a field, with the new columns behind.
void write_predictions(const PredictArguments& arguments,
                       const study::PredictedResponses& predictions,
                       std::ostream& stream) {
  data::CsvReader reader(arguments.data);
  const char* separator = "";
  const auto write = [&](std::string_view field) {
    stream << separator << data::csv_field(field);
    separator = ",";
  };
  for (const std::string& name : reader.header()) write(name);
  for (const std::string& name : names_of(predictions)) write(name);
  stream << '\n';
  std::vector<std::string_view> fields;
  for (std::size_t row = 0; reader.next(fields); ++row) {
    separator = "";
    for (const std::string_view field : fields) write(field);
    for (const auto& prediction : predictions.responses) {
      const double value = prediction.value[row];
      write(std::isnan(value) ? std::string() : data::shortest(value));
    }
    write(predictions.flags[row]);
    stream << '\n';
  }
}

void write_out(const PredictArguments& arguments, const study::PredictedResponses& predictions) {
  if (!arguments.out.empty()) {
    AtomicFile file(arguments.out);
    write_predictions(arguments, predictions, file.stream());
    file.commit();
  } else if (!arguments.common.json) {
    write_predictions(arguments, predictions, std::cout);
    std::cout.flush();
    if (!std::cout) throw InputError("writing to standard output failed");
  }
}

void print_summary(const PredictArguments& arguments,
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
      {"out", arguments.out.empty() ? ordered_json(nullptr) : ordered_json(arguments.out)},
      {"n", predictions.flags.size()},
      {"predicted", std::move(predicted)},
      {"flags", flags},
      {"notes", predictions.notes}};
  fmt::print("{}\n", result.dump(2));
}

void refuse_known_columns(const data::Table& table, const study::PredictedResponses& predictions) {
  for (const std::string& name : names_of(predictions)) {
    if (table.has(name)) {
      throw InputError("the file has this column already; give it another name",
                       {.file = table.file(), .column = name});
    }
  }
}

void run(const PredictArguments& arguments) {
  const study::ModelLibrary library = study::read_library(arguments.library);
  data::Table table =
      data::read_csv_table(arguments.data, {.text_columns = study::text_columns(library)});
  study::add_columns(fmt::format("{}", fmt::join(arguments.columns, ",")), table);
  const study::PredictedResponses predictions =
      study::predict_responses(library,
                               table,
                               {.level = kLevels.at(arguments.level),
                                .new_groups = kNewGroups.at(arguments.new_groups),
                                .role = arguments.role});
  for (const std::string& note : predictions.notes) say(arguments.common, "note: " + note);
  refuse_known_columns(table, predictions);
  write_out(arguments, predictions);
  if (arguments.common.json) print_summary(arguments, predictions);
}

}  // namespace

void add_predict_command(CLI::App& program) {
  const auto arguments = std::make_shared<PredictArguments>();
  CLI::App& command =
      *program.add_subcommand("predict", "Predict heights, crown bases and crown widths of trees");
  command
      .add_option("library",
                  arguments->library,
                  "library.json of a study, or what `silvafit fit --json` printed")
      ->type_name("LIBRARY.json")
      ->required();
  command.add_option("data", arguments->data, "Trees: a CSV file with a header")
      ->type_name("NEW.csv")
      ->required();
  command
      .add_option("--level",
                  arguments->level,
                  "population, or conditional on the random effects of the tree's group")
      ->check(CLI::IsMember({"population", "conditional"}))
      ->capture_default_str();
  command
      .add_option("--new-groups",
                  arguments->new_groups,
                  "Conditional predictions for groups that the fit has not seen")
      ->check(CLI::IsMember({"population", "missing", "error"}))
      ->capture_default_str();
  command.add_option("--role", arguments->role, "Which models of a study predict")
      ->check(CLI::IsMember({"ols", "covariates", "nlme"}))
      ->capture_default_str();
  command
      .add_option("--columns", arguments->columns, "Where columns come from, such as dbh=DBH_cm")
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
  command.add_option("--out", arguments->out, "CSV file to write (default: standard output)")
      ->type_name("FILE.csv");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit predict library.json new.csv --level conditional --out predictions.csv");
  command.callback([arguments] { run(*arguments); });
}

}  // namespace silvafit::cli
