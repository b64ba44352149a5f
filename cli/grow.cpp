// SPDX-License-Identifier: MIT
// `silvafit grow`: trees and stands as GLB, glTF, OBJ or PLY.
#include <memory>
#include <string>

#include "grow_command.hpp"
#include "output_files.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/study/grow_setting_list.hpp"
#include "table_arguments.hpp"

namespace silvafit::cli {
namespace {

struct GrowArguments {
  std::string file{};
  study::GrowSettings settings{};
  TableArguments table{};
  CommonOptions common{};
};

void run(const GrowArguments& arguments) {
  study::GrowSettings settings = arguments.settings;
  refuse_same_files({{"MORPHOLOGY.csv", arguments.file}, {"--grammar", settings.grammar}},
                    {{"--scene", settings.scene}, {"--manifest", settings.manifest}});
  if (settings.stream && arguments.common.json) {
    throw UsageError("--json has an entry for each tree; with --stream, use --manifest FILE.csv",
                     {.column = "--stream"});
  }
  settings.keeps_trees = arguments.common.json;
  settings.seed = arguments.common.seed;
  settings.threads = arguments.common.threads;
  const auto catalogue = tree::BuilderCatalogue::load(data_directory() / "models");
  const TreeTable trees = open_trees(arguments.file, arguments.table, arguments.common);
  Progress progress(arguments.common);
  const study::GrowResult result =
      study::grow(trees.table, catalogue, settings, callbacks(arguments.common, progress));
  progress.clear();
  report_grown(arguments.common, result);
}

}  // namespace

void add_grow_command(CLI::App& program) {
  auto arguments = std::make_shared<GrowArguments>();
  CLI::App* command =
      program.add_subcommand("grow", "Grow measured or predicted trees as 3D models");
  add_grow_options(*command, arguments->file, arguments->settings);
  command->add_flag(
      "--stream",
      arguments->settings.stream,
      "With --out: write trees while others are read, so that memory does not grow with their "
      "number; if the rows of a plot are not contiguous, they are sorted on disk first");
  add_layer_options(*command, arguments->table);
  add_common_options(*command, arguments->common);
  add_example(*command,
              "silvafit grow examples/fir-mixed/inventory.csv --plot 1 --scene plot1.glb");
  command->callback([arguments, command] {
    const bool has_ground = arguments->settings.out.empty() || arguments->settings.is_by_plot;
    refuse_idle(*command, "--ground", has_ground, "--scene or --per plot");
    run(*arguments);
  });
}

void add_grow_options(CLI::App& command, std::string& file, study::GrowSettings& options) {
  command
      .add_option(
          "morphology", file, "Inventory or predictions: a CSV file, workbook, layer or database")
      ->required()
      ->type_name("FILE.csv");
  each_setting(options, SettingOptions(command, "Trees and scenes"));
  command.get_option("--per")->needs(command.get_option("--out"));
  command.get_option("--models")->needs(command.get_option("--share"));
  command.get_option("--seconds")->needs(command.get_option("--animate"));
  add_reading_options(command, options.reading);
}

}  // namespace silvafit::cli
