// SPDX-License-Identifier: MIT
// `silvafit predict`: predictions of a model library for new trees.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "command.hpp"
#include "help.hpp"
#include "output_files.hpp"
#include "row_output.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/predict_table.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

struct PredictArguments {
  CommonOptions common{};
  TableArguments table{};
  std::vector<std::string> files{};
  std::string library{};
  std::string data{};
  study::PredictionSettings settings{};
  int digits = kPredictedDigits;
  bool stream = false;
  std::string out{};
};

/// Determines which of the two files is the library and which is the table of trees.
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

void run(const CLI::App& command, PredictArguments arguments) {
  study::refuse_idle_settings(arguments.settings, given_options(command));
  sort_files(arguments);
  refuse_same_files({{"LIBRARY.json", arguments.library}, {"NEW.csv", arguments.data}},
                    {{"--out", arguments.out}});
  require_table_output(arguments.out);
  const study::ModelLibrary library =
      study::find_library(arguments.library, data_directory() / "models");
  const study::Catalogue catalogue = study::Catalogue::load(data_directory() / "models");
  arguments.settings.threads = arguments.common.threads;
  arguments.settings.equations.models = data_directory() / "models";
  const TreeTable trees = open_trees(arguments.data, arguments.table, arguments.common);
  const study::ReadingSettings& reading = arguments.settings.reading;
  TableWithColumns table(arguments.out, arguments.stream, reading, arguments.common);
  const auto write = [&](const data::TableSource& rows, const study::TablePrediction& part) {
    const AddedColumns added{.table = study::new_columns(part), .digits = arguments.digits};
    study::refuse_known_columns(added.table.names(), part.table.names(), part.table.file());
    table.write(rows, added, part.is_in_file_order);
  };
  Progress progress(arguments.common);
  const study::PredictionSummary summary =
      study::predict_trees(trees.table,
                           library,
                           catalogue,
                           arguments.settings,
                           arguments.stream,
                           write,
                           callbacks(arguments.common, progress));
  progress.clear();
  table.finish(trees);
  if (arguments.common.json) print_json_value(study::json_of(summary, arguments.out));
}

void add_file_options(CLI::App& command, PredictArguments& arguments) {
  command
      .add_option("files",
                  arguments.files,
                  "The library (library.json of a study, the output of `silvafit fit --json`, or a "
                  "published library such as shanxia-2023) and a table of trees (CSV, workbook, "
                  "layer, database); with --library "
                  "only the file of trees")
      ->type_name("LIBRARY.json NEW.csv")
      ->expected(1, 2)
      ->required();
  command.add_option("--library", arguments.library, "Library, instead of the first file")
      ->type_name("LIBRARY");
}

}  // namespace

void add_predict_command(CLI::App& program) {
  const auto arguments = std::make_shared<PredictArguments>();
  CLI::App& command =
      *program.add_subcommand("predict", "Predict heights, crown bases and crown widths of trees");
  add_file_options(command, *arguments);
  add_prediction_options(command, arguments->settings);
  add_layer_options(command, arguments->table);
  add_digits_option(command, arguments->digits);
  study::ReadingSettings& reading = arguments->settings.reading;
  add_reading_options(
      command, reading, {"columns", "missing", "fill_down", "case_sensitive", "trust_units"});
  add_equation_options(command, arguments->settings.equations);
  add_output_option(command, "--out", arguments->out, kTableOutputHelp);
  command.add_flag("--stream", arguments->stream, kStreamHelp);
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit predict library.json new.csv --level calibrated --interval 0.95 --out "
              "predictions.csv");
  command.callback([arguments, &command] { run(command, *arguments); });
}

}  // namespace silvafit::cli
