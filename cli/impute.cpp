// SPDX-License-Identifier: MIT
// `silvafit impute`: an inventory with imputed values for those that were not measured.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "command.hpp"
#include "help.hpp"
#include "output_files.hpp"
#include "row_output.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/impute_table.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

struct ImputeArguments {
  CommonOptions common{};
  TableArguments table{};
  study::ImputeOptions impute{};
  study::ReadingSettings reading{};
  std::string data{};
  std::string out{};
  int digits = kPredictedDigits;
  bool stream = false;
};

void run(ImputeArguments& arguments) {
  refuse_same_files({{"INVENTORY.csv", arguments.data}}, {{"--out", arguments.out}});
  const auto catalogue = study::Catalogue::load(data_directory() / "models");
  require_table_output(arguments.out);
  arguments.impute.seed = arguments.common.seed;
  arguments.impute.threads = arguments.common.threads;
  const TreeTable trees = open_trees(arguments.data, arguments.table, arguments.common);
  TableWithColumns table(arguments.out, arguments.stream, arguments.reading, arguments.common);
  const auto write = [&](const data::TableSource& rows, const study::TableImputation& part) {
    table.write(rows, study::added_columns(part, arguments.digits), part.is_in_file_order);
  };
  Progress progress(arguments.common);
  const study::ImputationSummary summary =
      study::impute_trees(trees.table,
                          catalogue,
                          arguments.impute,
                          arguments.reading,
                          arguments.stream,
                          write,
                          callbacks(arguments.common, progress));
  progress.clear();
  table.finish(trees);
  for (const std::string& line : study::summary_of(summary)) say(arguments.common, line);
  if (arguments.common.json) print_json_value(study::json_of(summary, arguments.out));
}

}  // namespace

void add_impute_command(CLI::App& program) {
  const auto arguments = std::make_shared<ImputeArguments>();
  CLI::App& command = *program.add_subcommand(
      "impute", "Fill in heights, crown bases or crown widths that were not measured");
  command.add_option("data", arguments->data, "Trees: a CSV file, workbook, layer or database")
      ->type_name("INVENTORY.csv")
      ->required();
  add_layer_options(command, arguments->table);
  each_setting(arguments->impute, SettingOptions(command, "Imputation"));
  add_reading_options(command, arguments->reading);
  add_digits_option(command, arguments->digits);
  add_output_option(command, "--out", arguments->out, kTableOutputHelp);
  command.add_flag("--stream", arguments->stream, kStreamHelp);
  add_common_options(command, arguments->common);
  add_example(command, "silvafit impute inventory.csv --response h --by species --out filled.csv");
  command.callback([arguments, &command] {
    study::refuse_idle_settings(arguments->impute, given_options(command));
    run(*arguments);
  });
}

}  // namespace silvafit::cli
