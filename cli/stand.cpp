// SPDX-License-Identifier: MIT
// silvafit stand: stand tables by plot, stratum, species, diameter and structure.
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "inventory_options.hpp"
#include "output_files.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/stand_summary.hpp"
#include "stand_output.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

struct StandArguments {
  std::string inventory{};
  study::StandOptions options{};
  std::string out{};
  TableArguments table{};
  CommonOptions common{};
};

void run(const StandArguments& arguments) {
  refuse_same_files(
      {{"INVENTORY.csv", arguments.inventory}, {"--window", arguments.options.units.window}},
      files_in({"--out", arguments.out},
               {"plots.csv",
                "strata.csv",
                "species.csv",
                "diameters.csv",
                "classes.csv",
                "indices.csv"}));
  study::StandOptions options = arguments.options;
  options.threads = arguments.common.threads;
  const TreeTable trees =
      open_inventory(arguments.inventory, arguments.table, options.units, arguments.common);
  Progress progress(arguments.common);
  const study::StandSummary summary =
      study::stand_summary(trees.table, options, callbacks(arguments.common, progress));
  if (!arguments.out.empty()) {
    stand::write_stand(summary.inventory.inventory, summary.report, arguments.out);
  }
  if (arguments.common.json) {
    print_json_value(study::json_of(summary));
  } else {
    print_stand(summary.report);
  }
}

void add_figure_options(CLI::App& command, StandArguments& arguments) {
  stand::StandReportOptions& report = arguments.options.report;
  command
      .add_option("--layers", report.species.layers.bounds_m, "Limits of the height layers in m")
      ->delimiter(',')
      ->capture_default_str();
  command
      .add_option("--quadrat",
                  report.species.quadrat_m,
                  "Side of the quadrats for species frequencies in m (default: the plots; 10 m if "
                  "there is one plot)")
      ->type_name("M");
  command
      .add_option("--dominant-trees",
                  report.species.dominant_trees_per_ha,
                  "Number of thickest trees per ha for the dominant height")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command.add_option("--class-width", report.diameter_class_cm, "Width of a diameter class in cm")
      ->capture_default_str();
  command
      .add_option(
          "--plot-area", report.plot_area_m2, "Area of every plot in m2, instead of a window")
      ->type_name("M2");
  command.add_option("--stratum", report.stratum, "Column with the stratum of each plot")
      ->type_name("COLUMN");
  command
      .add_option("--stratum-area",
                  arguments.options.stratum_areas,
                  "Areas of the strata in ha, for totals, such as A=120,B=33.5")
      ->delimiter(',')
      ->type_name("STRATUM=HA,...");
}

}  // namespace

void add_stand_command(CLI::App& program) {
  const auto arguments = std::make_shared<StandArguments>();
  CLI::App& command = *program.add_subcommand(
      "stand",
      "Print stand tables: density, basal area, heights, diameters, importance values, structure");
  add_inventory_options(
      command, arguments->inventory, arguments->options.reading, arguments->table);
  add_figure_options(command, *arguments);
  add_unit_options(command, arguments->options.units);
  add_window_layer_option(command, arguments->table);
  command.add_option("--out", arguments->out, "Write the tables as CSV files to this folder")
      ->type_name("DIR");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit stand examples/fir-mixed/inventory.csv --per stand --window "
              "examples/fir-mixed/window.geojson");
  command.callback([arguments, &command] {
    const study::UnitSettings& units = arguments->options.units;
    refuse_idle_unit_options(command, units, study::further_indices(units));
    run(*arguments);
  });
}

}  // namespace silvafit::cli
