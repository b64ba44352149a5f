// SPDX-License-Identifier: MIT
// `silvafit simulate`: an inventory with known true values.
#include "silvafit/study/simulate.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "command.hpp"
#include "output_files.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "silvafit/source/open_table.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

struct SimulateOptions {
  CommonOptions common{};
  std::filesystem::path design{};
  std::filesystem::path out{};
  std::filesystem::path truth{};
};

void print_summary(const SimulateOptions& options,
                   const study::SimulationDesign& design,
                   const study::SimulatedStand& stand) {
  if (options.common.json) {
    nlohmann::ordered_json result{{"schema", "silvafit-simulation/1"},
                                  {"out", options.out.string()},
                                  {"seed", options.common.seed},
                                  {"trees", stand.inventory.size()},
                                  {"plots", design.plots.size()},
                                  {"crowding_passes", stand.crowding_passes},
                                  {"crowding_unsettled", stand.crowding_unsettled}};
    for (std::size_t s = 0; s < design.species.size(); ++s) {
      result["species"][design.species[s].code] = stand.species[s].trees;
    }
    print_json_value(result);
    return;
  }
  print_text("{:<8} {:>7}\n", "species", "trees");
  for (std::size_t s = 0; s < design.species.size(); ++s) {
    print_text("{:<8} {:>7}\n", design.species[s].code, stand.species[s].trees);
  }
}

void run(const SimulateOptions& options) {
  refuse_same_files({{"DESIGN.json", options.design}},
                    {{"--out", options.out}, {"--truth", options.truth}});
  const std::string out = options.out.string();
  require_table_output(out);
  if (source::is_layered(options.truth.string())) {
    throw UsageError("is a JSON file, not a workbook or layer", {.column = "--truth"});
  }
  const study::SimulationDesign design = study::read_design(options.design);
  const study::SimulatedStand stand =
      study::simulate(design, options.common.seed, options.common.threads);
  if (is_layer_output(out)) {
    write_trees(out, stand::to_table(stand.inventory), {}, {}, options.common);
  } else {
    data::write_csv_table(stand::to_table(stand.inventory), options.out);
  }
  if (!options.truth.empty()) {
    write_file(options.truth, study::truth_json(design, stand, options.common.seed));
  }
  for (const std::string& note : study::notes_on_limits(design, stand)) {
    say(options.common, "note: " + note);
  }
  if (stand.crowding_unsettled > 0) {
    say(options.common,
        fmt::format("crown width and C did not come to agree for {} of {} trees; where crowding "
                    "narrows crowns, they cannot always",
                    stand.crowding_unsettled,
                    stand.inventory.size()));
  }
  print_summary(options, design, stand);
}

}  // namespace

void add_simulate_command(CLI::App& program) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* command = program.add_subcommand(
      "simulate", "Simulate an inventory with known true values from a design");
  add_common_options(*command, options->common);
  command->add_option("design", options->design, "Design of the stand (JSON)")
      ->type_name("DESIGN.json")
      ->required();
  command
      ->add_option("--out",
                   options->out,
                   "Inventory to write: CSV, or by its ending a layer (.gpkg, .fgb) or a workbook "
                   "(.xlsx, .ods)")
      ->required();
  command->add_option("--truth", options->truth, "Where to write what was drawn (JSON)");
  add_example(*command,
              "silvafit simulate examples/fir-mixed/design.json --out inventory.csv "
              "--truth truth.json --seed 1");
  command->callback([options] { run(*options); });
}

}  // namespace silvafit::cli
