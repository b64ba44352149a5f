// SPDX-License-Identifier: MIT
// silvafit stand: stand tables by plot, stratum, species, diameter and structure.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "inventory_options.hpp"
#include "output_files.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "stand_output.hpp"
#include "standard_output.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct StandArguments {
  InventoryArguments inventory{};
  UnitArguments units{};
  stand::StandReportOptions report{};
  std::vector<std::string> stratum_areas{};
  std::string out{};
  CommonOptions common{};
};

void set_stratum_areas(const StandArguments& arguments, stand::StandReportOptions& options) {
  for (const std::string& part : arguments.stratum_areas) {
    const std::size_t sign = part.rfind('=');
    double hectares = 0.0;
    const bool is_pair = sign != std::string::npos &&
                         data::parse_number(std::string_view(part).substr(sign + 1), hectares);
    if (!is_pair) {
      throw UsageError(fmt::format("'{}' is not STRATUM=HECTARES, such as A=120", part),
                       {.column = "--stratum-area"});
    }
    options.stratum_areas_ha[part.substr(0, sign)] = hectares;
  }
  if (!options.stratum_areas_ha.empty() && options.stratum.empty()) {
    throw UsageError("--stratum-area needs --stratum, the column of the strata",
                     {.column = "--stratum-area"});
  }
}

void print_json(const StandArguments& arguments,
                const stand::CheckedInventory& checked,
                const stand::StandReport& report,
                double seconds) {
  ordered_json notes = checked.notes;
  for (const std::string& note : report.notes) notes.push_back(note);
  ordered_json result{{"schema", "silvafit-stand/1"},
                      {"silvafit", version()},
                      {"inventory", arguments.inventory.path},
                      {"excluded", checked.excluded_tree_count},
                      {"edge", arguments.units.edge},
                      {"per", arguments.units.per}};
  result.update(stand_json(report));
  result["recognized"] = checked.recognized;
  result["notes"] = std::move(notes);
  result["seconds"] = seconds;
  print_json_value(result);
}

void run(const StandArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  refuse_same_files(
      {{"INVENTORY.csv", arguments.inventory.path}, {"--window", arguments.units.window}},
      files_in({"--out", arguments.out},
               {"plots.csv",
                "strata.csv",
                "species.csv",
                "diameters.csv",
                "classes.csv",
                "indices.csv"}));
  stand::StandReportOptions options = arguments.report;
  options.units = unit_options(arguments.units, arguments.common);
  set_stratum_areas(arguments, options);
  stand::InventoryOptions reading;
  if (!options.stratum.empty()) reading.keep = {options.stratum};
  const stand::CheckedInventory checked =
      read_inventory(arguments.inventory, reading, arguments.common);
  const stand::StandReport report = stand::stand_report(checked.inventory, options);
  for (const std::string& note : report.notes) say(arguments.common, "note: " + note);
  if (!arguments.out.empty()) write_stand(checked.inventory, report, arguments.out);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  if (arguments.common.json) {
    print_json(arguments, checked, report, elapsed.count());
  } else {
    print_stand(report);
  }
}

void add_figure_options(CLI::App& command, StandArguments& arguments) {
  stand::StandReportOptions& report = arguments.report;
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
                  arguments.stratum_areas,
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
  add_inventory_options(command, arguments->inventory);
  add_figure_options(command, *arguments);
  add_unit_options(command, arguments->units);
  command.add_option("--out", arguments->out, "Write the tables as CSV files to this folder")
      ->type_name("DIR");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit stand examples/fir-mixed/inventory.csv --per stand --window "
              "examples/fir-mixed/window.geojson");
  command.callback([arguments, &command] {
    refuse_idle_unit_options(command, arguments->units, further_indices(arguments->units));
    run(*arguments);
  });
}

}  // namespace silvafit::cli
