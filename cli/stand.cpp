// SPDX-License-Identifier: MIT
// silvafit stand: stand tables by plot, stratum, species, diameter and structure.
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "command.hpp"
#include "inventory_options.hpp"
#include "output_files.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/source/write_layers.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/stand_growth.hpp"
#include "silvafit/study/stand_summary.hpp"
#include "stand_output.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

struct StandArguments {
  std::string inventory{};
  study::StandOptions options{};
  std::string out{};
  bool growth = false;
  TableArguments table{};
  PlotsArgument plots{};
  CommonOptions common{};
};

/// Writes tables as sheets of a workbook, or as CSV files into a folder.
void write_tables(const std::string& out, std::vector<std::pair<std::string, data::Table>> tables) {
  if (!is_layer_output(out)) {
    const ResultFolder results(out);
    for (const auto& [name, table] : tables) {
      data::write_csv_table(table, std::filesystem::path(out) / (name + ".csv"));
    }
    return;
  }
  std::vector<source::Layer> sheets;
  for (auto& [name, table] : tables) sheets.push_back({.name = name, .table = std::move(table)});
  source::write_layers(out, sheets, std::nullopt);
}

void run_tables(const StandArguments& arguments,
                const TreeTable& trees,
                const study::StandOptions& options) {
  Progress progress(arguments.common);
  const study::StandSummary summary =
      study::stand_summary(trees.table, options, callbacks(arguments.common, progress));
  if (is_layer_output(arguments.out)) {
    write_tables(arguments.out, stand::tables_of(summary.report));
  } else if (!arguments.out.empty()) {
    stand::write_stand(summary.inventory.inventory, summary.report, arguments.out);
  }
  if (arguments.common.json) {
    print_json_value(study::json_of(summary));
  } else {
    print_stand(summary.report);
  }
}

void run_growth(const StandArguments& arguments,
                const TreeTable& trees,
                const study::StandOptions& options) {
  Progress progress(arguments.common);
  const study::GrowthSummary summary =
      study::stand_growth(trees.table, options, callbacks(arguments.common, progress));
  if (!arguments.out.empty()) write_tables(arguments.out, stand::tables_of(summary.report));
  if (arguments.common.json) {
    print_json_value(study::json_of(summary));
  } else {
    print_growth(summary.report);
  }
}

void run(const StandArguments& arguments) {
  require_table_output(arguments.out);
  if (arguments.out.ends_with(".fgb")) {
    throw UsageError("a FlatGeobuf file has one table only; give a folder, .xlsx, .ods or .gpkg",
                     {.column = "--out"});
  }
  refuse_same_files({{"INVENTORY.csv", arguments.inventory},
                     {"--window", arguments.options.units.window},
                     {"--plots", arguments.plots.file}},
                    files_in({"--out", arguments.out},
                             {"plots.csv",
                              "strata.csv",
                              "species.csv",
                              "diameters.csv",
                              "classes.csv",
                              "indices.csv",
                              "growth_trees.csv",
                              "growth_plots.csv",
                              "growth_strata.csv"}));
  study::StandOptions options = arguments.options;
  options.threads = arguments.common.threads;
  options.equations.models = data_directory() / "models";
  const TreeTable trees =
      open_inventory(arguments.inventory, arguments.table, options.units, arguments.common);
  open_plots(arguments.plots, trees, arguments.common, options.sampling);
  if (arguments.growth) {
    run_growth(arguments, trees, options);
  } else {
    run_tables(arguments, trees, options);
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
  add_sampling_options(command, arguments->options.sampling, arguments->plots);
  add_equation_options(command, arguments->options.equations);
  command.add_flag("--growth",
                   arguments->growth,
                   "Growth between repeated measurements instead of stand tables: increments, "
                   "ingrowth, mortality and cut; needs a column year or date");
  command
      .add_option("--out",
                  arguments->out,
                  "Write the tables as CSV files to this folder, or as sheets of a workbook "
                  "(.xlsx, .ods)")
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
