// SPDX-License-Identifier: MIT
// silvafit stand: stand tables by plot, stratum, species, diameter and structure.
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "command.hpp"
#include "help.hpp"
#include "output_files.hpp"
#include "row_output.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/paths.hpp"
#include "silvafit/source/write_layers.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
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
  std::string report{};
  std::string command{};  ///< as it was given
  bool growth = false;
  TableArguments table{};
  source::TableChoice plots{};
  CommonOptions common{};
};

bool is_folder(const std::string& out) { return !out.empty() && !is_layer_output(out); }

/// Writes tables as sheets of a workbook, or as CSV files into a folder.
void write_tables(const std::string& out, const Tables& tables) {
  if (is_layer_output(out)) {
    std::vector<source::Layer> sheets;
    for (const auto& [name, table] : tables) sheets.push_back({.name = name, .table = table});
    return source::write_layers(out, sheets, std::nullopt);
  }
  for (const auto& [name, table] : tables) {
    data::write_csv_table(table, std::filesystem::path(out) / (name + ".csv"));
  }
}

void run_tables(const StandArguments& arguments,
                const TreeTable& trees,
                const study::StandOptions& options) {
  std::optional<ResultFolder> folder;
  // A row for each tree, written while the next trees are read.
  std::optional<RowOutput> rows;
  const auto write = [&](const stand::CheckedInventory& part, const stand::StructuralUnits& units) {
    if (!is_folder(arguments.out)) return;
    if (!folder) folder.emplace(arguments.out);
    if (!rows) rows.emplace((std::filesystem::path(arguments.out) / "indices.csv").string());
    rows->begin(stand::header_of_units(units), part.is_in_file_order);
    stand::write_structural_units(
        part.inventory, units, [&](std::size_t tree, std::string_view text) {
          rows->add(part.inventory.lines[tree], text);
        });
  };
  Progress progress(arguments.common);
  const study::StandSummary summary =
      study::stand_summary(trees.table, options, callbacks(arguments.common, progress), write);
  progress.clear();
  if (is_folder(arguments.out) && !folder) folder.emplace(arguments.out);
  const Tables tables = study::tables_of(summary);
  if (!arguments.out.empty()) write_tables(arguments.out, tables);
  if (rows) rows->finish();
  if (arguments.common.json) {
    print_json_value(study::json_of(summary));
  } else {
    print_stand(summary, tables);
  }
  if (arguments.report.empty()) return;
  study::write_stand_page(summary,
                          options,
                          study::Catalogue::load(data_directory() / "models"),
                          arguments.command,
                          bundled_page("report.html"),
                          arguments.report);
}

void run_growth(const StandArguments& arguments,
                const TreeTable& trees,
                const study::StandOptions& options) {
  Progress progress(arguments.common);
  const study::GrowthSummary summary =
      study::stand_growth(trees.table, options, callbacks(arguments.common, progress));
  std::optional<ResultFolder> folder;
  if (is_folder(arguments.out)) folder.emplace(arguments.out);
  const Tables tables = stand::tables_of(summary.report);
  if (!arguments.out.empty()) write_tables(arguments.out, tables);
  if (arguments.common.json) {
    print_json_value(study::json_of(summary));
  } else {
    print_growth(summary.report, tables);
  }
}

void run(const StandArguments& arguments) {
  require_table_output(arguments.out);
  if (arguments.out.ends_with(".fgb")) {
    throw UsageError("a FlatGeobuf file has one table only; give a folder, .xlsx, .ods or .gpkg",
                     {.column = "--out"});
  }
  std::vector<NamedFile> written = files_in({"--out", arguments.out},
                                            {"plots.csv",
                                             "strata.csv",
                                             "domains.csv",
                                             "thinning.csv",
                                             "trees.csv",
                                             "sites.csv",
                                             "species.csv",
                                             "diameters.csv",
                                             "classes.csv",
                                             "indices.csv",
                                             "growth_trees.csv",
                                             "growth_plots.csv",
                                             "growth_strata.csv"});
  written.push_back({"--report", arguments.report});
  refuse_same_files({{"INVENTORY.csv", arguments.inventory},
                     {"--window", arguments.options.units.window},
                     {"--plots", arguments.options.sampling.plots_file}},
                    written);
  if (arguments.growth && arguments.options.stream) {
    throw UsageError("growth needs all measurements of a tree in memory; omit --stream or --growth",
                     {.column = "--stream"});
  }
  if (!arguments.report.empty() && arguments.growth) {
    throw UsageError("growth has no report page; omit --report or --growth",
                     {.column = "--report"});
  }
  study::StandOptions options = arguments.options;
  if (!arguments.report.empty() && options.report.by.empty()) options.report.by = {"species"};
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

}  // namespace

void add_stand_command(CLI::App& program, std::string command_line) {
  const auto arguments = std::make_shared<StandArguments>();
  arguments->command = std::move(command_line);
  CLI::App& command = *program.add_subcommand(
      "stand",
      "Print stand tables: density, basal area, heights, diameters, importance values, structure");
  add_inventory_options(
      command, arguments->inventory, arguments->options.reading, arguments->table);
  each_setting(arguments->options, SettingOptions(command, "Stand figures"));
  add_unit_options(command, arguments->options.units);
  add_window_layer_option(command, arguments->table);
  add_sampling_options(command, arguments->options.sampling, arguments->plots);
  add_equation_options(command, arguments->options.equations);
  command.add_flag("--growth",
                   arguments->growth,
                   "Growth between repeated measurements instead of stand tables: increments, "
                   "ingrowth, mortality and cut; needs a column year or date");
  add_output_option(command,
                    "--out",
                    arguments->out,
                    "Write the tables as CSV files to this folder, or as sheets of a workbook "
                    "(.xlsx, .ods)",
                    "DIR");
  add_output_option(command,
                    "--report",
                    arguments->report,
                    "Write a page with the stand table, diameters, height curves and the map",
                    "FILE.html");
  command.add_flag(
      "--stream",
      arguments->options.stream,
      "Read plot by plot, so that memory does not grow with the number of trees; if the rows of a "
      "plot are not contiguous, they are sorted on disk first");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit stand examples/fir-mixed/inventory.csv --per stand --window "
              "examples/fir-mixed/window.geojson");
  command.callback([arguments, &command] {
    const study::StandOptions& options = arguments->options;
    const study::GivenName given = given_options(command);
    arguments->growth ? refuse_idle_on_growth(options, given) : refuse_idle(options, given);
    run(*arguments);
  });
}

}  // namespace silvafit::cli
