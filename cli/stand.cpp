// SPDX-License-Identifier: MIT
// silvafit stand: stand tables by plot, stratum, species, diameter and structure.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
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
#include "silvafit/stand/growth.hpp"
#include "silvafit/stand/stand_json.hpp"
#include "silvafit/study/analysis_setting_list.hpp"
#include "silvafit/study/stand_summary.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"
#include "text_table.hpp"

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

using Tables = std::vector<std::pair<std::string, data::Table>>;
using Shown = std::vector<ShownColumn>;

void add_quantities(const stand::StandReport& report, const char* error, Shown& columns) {
  for (const std::string& name : report.quantities) {
    columns.push_back({name + "_per_ha", name + "/ha", 1, error[0] == 0 ? "" : name + error});
  }
}

void print_areas(const stand::StandReport& report, const data::Table& plots) {
  Shown columns{{"plot", "plot", 0, "", "stand"},
                {"trees", "trees", 0},
                {"area_ha", "ha", 4},
                {"stems_per_ha", "N/ha"},
                {"basal_area_m2_per_ha", "G m2/ha"},
                {"quadratic_mean_dbh_cm", "QMD cm"},
                {"mean_height_m", "mean h"},
                {"dominant_height_m", "dom. h"},
                {"crown_cover_percent", "cover %"},
                {"clark_evans_R", "R", 3},
                {"clark_evans_R_donnelly", "R Donnelly", 3}};
  add_quantities(report, "", columns);
  TextTable table(columns);
  table.add(plots);
  if (report.areas.size() > 1) {
    stand::StandReport all;
    all.quantities = report.quantities;
    all.areas.push_back({.area = {.name = "all"}, .figures = report.all});
    table.add(stand::tables_of(all).front().second);
  }
  print_text("Plots (dominant height: the {} thickest trees per ha)\n",
             report.dominant_trees_per_ha);
  table.print();
}

/// Estimates with standard errors, of strata or of kinds of trees.
void print_estimates(const stand::StandReport& report, Shown columns, const data::Table& rows) {
  columns.insert(columns.end(),
                 {{"trees", "trees", 0},
                  {"stems_per_ha", "N/ha", 1, "stems_per_ha_se"},
                  {"basal_area_m2_per_ha", "G m2/ha", 2, "basal_area_m2_per_ha_se"},
                  {"quadratic_mean_dbh_cm", "QMD cm", 1, "quadratic_mean_dbh_cm_se"},
                  {"mean_height_m", "mean h", 1, "mean_height_m_se"}});
  add_quantities(report, "_per_ha_se", columns);
  if (std::isfinite(report.strata.back().area_ha)) {
    columns.push_back({"area_ha", "ha", 2});
    columns.push_back({"stems_total", "N", 0, "stems_total_se"});
    columns.push_back({"basal_area_m2_total", "G m2", 0, "basal_area_m2_total_se"});
    for (const std::string& name : report.quantities) {
      columns.push_back({name + "_total", name, 0, name + "_total_se"});
    }
  }
  TextTable table(columns);
  table.add(rows);
  table.print();
}

void print_species(const stand::StandReport& report, const data::Table& species) {
  Shown columns{{"species", "species", 0, "", "(none)"}, {"stems_per_ha", "N/ha"}};
  const std::size_t layers = report.species.empty() ? 0 : report.species.front().layers.size();
  for (std::size_t i = layers; i > 0; --i) {
    const std::string name = report.layers.name_of(i - 1);
    columns.push_back({name + "_importance", "IV " + name, 2, name + "_importance_plot_sd"});
  }
  columns.insert(columns.end(),
                 {{"importance", "IV %", 2, "importance_plot_sd"},
                  {"mean_dbh_cm", "dbh cm", 2, "sd_dbh_cm"},
                  {"mean_height_m", "h m", 2, "sd_height_m"},
                  {"basal_area_m2", "G m2", 2},
                  {"dominant_height_m", "dom. h"}});
  TextTable table(columns);
  table.add(species);
  print_text(
      "Species (IV: importance value in %, +- standard deviation over plots; frequency from {})\n",
      report.quadrat_m > 0.0 ? fmt::format("quadrats of {} m", report.quadrat_m) : "plots");
  table.print();
}

void print_diameters(const stand::StandReport& report) {
  TextTable table({"dbh cm", "trees", "N/ha", "G m2/ha"});
  for (const stand::DiameterClass& one : report.diameters) {
    table.add({fmt::format("{}-{}", one.low_cm, one.high_cm),
               std::to_string(one.trees),
               rounded(one.stems_per_ha),
               rounded(one.basal_area_m2_per_ha, 2)});
  }
  print_text("Diameters\n");
  table.print();
}

/// \param means  of units by species, and of all trees
void print_structure(const data::Table& means, std::size_t neighbors) {
  std::vector<std::string> indices = means.names();
  indices.erase(indices.begin(), std::ranges::find(indices, "W"));
  std::vector<std::string> header{"species", "core trees"};
  header.insert(header.end(), indices.begin(), indices.end());
  TextTable table(header);
  for (std::size_t row = 0; row < means.rows(); ++row) {
    const bool is_all = means.text("kind")[row] == "all";
    const std::string species(means.text("species")[row]);
    std::vector<std::string> cells{is_all ? "all" : name_or(species, "(none)"),
                                   fmt::format("{}", means.numbers("core_trees")[row])};
    for (const std::string& name : indices) cells.push_back(rounded(means.numbers(name)[row], 3));
    table.add(std::move(cells));
  }
  print_text("Structure, means over core trees ({} neighbors)\n", neighbors);
  table.print();
}

void print_joint(const stand::StandReport& report) {
  for (const stand::NamedJointDistribution& joint : report.joint) {
    const std::size_t classes = joint.distribution.neighbors + 1;
    const auto class_name = [classes](std::size_t i) {
      return fmt::format("{:.3g}", static_cast<double>(i) / static_cast<double>(classes - 1));
    };
    std::vector<std::string> header{joint.first + " \\ " + joint.second};
    for (std::size_t i = 0; i < classes; ++i) header.push_back(class_name(i));
    TextTable table(header);
    for (std::size_t i = 0; i < classes; ++i) {
      std::vector<std::string> row{class_name(i)};
      for (std::size_t j = 0; j < classes; ++j) {
        row.push_back(rounded(100.0 * joint.distribution.at(i, j)));
      }
      table.add(std::move(row));
    }
    print_text(
        "{} and {}: % of {} core trees\n", joint.first, joint.second, joint.distribution.trees);
    table.print();
  }
}

using stand::GrowthPart;

using TitledParts = std::vector<std::pair<GrowthPart, const char*>>;

/// With column headings; changes are per year. Plots of fixed area have no change of factors.
TitledParts parts_of(const stand::GrowthReport& report) {
  TitledParts parts{{GrowthPart::kStart, "start"},
                    {GrowthPart::kEnd, "end"},
                    {GrowthPart::kNetChange, "net /yr"},
                    {GrowthPart::kSurvivorGrowth, "survivors /yr"},
                    {GrowthPart::kIngrowth, "ingrowth /yr"},
                    {GrowthPart::kMortality, "mortality /yr"},
                    {GrowthPart::kCut, "cut /yr"},
                    {GrowthPart::kNotFound, "not found /yr"}};
  const bool changes = std::ranges::any_of(report.plots, [](const stand::PlotGrowth& plot) {
    return std::ranges::any_of(plot.values, [](const stand::GrowthParts& value) {
      return std::abs(value[static_cast<std::size_t>(GrowthPart::kFactorChange)]) > 0.0;
    });
  });
  if (changes) parts.emplace_back(GrowthPart::kFactorChange, "factors /yr");
  return parts;
}

void print_fates(const stand::GrowthReport& report) {
  std::map<std::string, std::size_t> trees;
  for (const stand::TreeGrowth& tree : report.trees) ++trees[word_of(tree.fate)];
  print_text("Trees by fate in a period:");
  for (const auto& [fate, count] : trees) print_text(" {} {}", count, fate);
  print_text("\n\n");
}

void print_growth_of_plots(const std::string& value,
                           const TitledParts& parts,
                           const data::Table& plots) {
  Shown columns{{"plot", "plot"}, {"from", "from"}, {"to", "to"}, {"years", "years"}};
  for (const auto& [part, title] : parts) {
    columns.push_back({fmt::format("{}_{}", value, word_of(part)), title, 2});
  }
  TextTable table(columns);
  table.add(plots);
  print_text("{} per ha, by plot\n", value);
  table.print();
}

void print_growth_of_strata(const stand::GrowthReport& report,
                            const TitledParts& parts,
                            std::size_t value) {
  if (report.strata.empty()) return;
  std::vector<std::string> header{"stratum", "period", "plots"};
  for (const auto& [part, title] : parts) header.emplace_back(title);
  TextTable table(header);
  for (const stand::StratumGrowth& stratum : report.strata) {
    const bool is_all = stratum.kind == stand::StratumFigures::Kind::kAll;
    std::vector<std::string> row{is_all ? "all" : name_or(stratum.name, "(none)"),
                                 std::to_string(stratum.period),
                                 std::to_string(stratum.plots)};
    for (const auto& [part, title] : parts) {
      const stand::Estimate& estimate = stratum.values[value][static_cast<std::size_t>(part)];
      row.push_back(with_error(estimate.per_ha, estimate.standard_error, 2));
    }
    table.add(std::move(row));
  }
  print_text("{} per ha, by stratum, with standard errors over plots\n", report.values[value]);
  table.print();
}

void print_thinning(data::Table plots) {
  Shown columns{{"plot", "plot", 0, "", "stand"}};
  using Titled = std::pair<const char*, const char*>;
  for (const auto& [value, title] : {Titled{"stems_per_ha", "N/ha"},
                                     Titled{"basal_area_m2_per_ha", "G m2/ha"},
                                     Titled{"quadratic_mean_dbh_cm", "QMD cm"}}) {
    columns.push_back({fmt::format("{}_before", value), title});
    columns.push_back({fmt::format("{}_removed", value), "removed"});
    columns.push_back({fmt::format("{}_after", value), "after"});
  }
  columns.push_back({"dominant_height_m_before", "dom. h"});
  columns.push_back({"dominant_height_m_after", "after"});
  // The last row has all plots together.
  if (plots.rows() == 2) plots = plots.select(std::vector<std::size_t>{0});
  TextTable table(columns);
  table.add(plots);
  print_text("Thinning: before, removed trees, after\n");
  table.print();
}

void print_sites(const data::Table& sites) {
  TextTable table(Shown{{"plot", "plot", 0, "", "stand"},
                        {"age", "age"},
                        {"dominant_height_m", "dom. h"},
                        {"site_index_m", "site index m"}});
  table.add(sites);
  print_text("Site index\n");
  table.print();
}

/// \param tables  of the summary
void print_stand(const study::StandSummary& summary, const Tables& tables) {
  const stand::StandReport& report = summary.report;
  const auto find = [&tables](const std::string& name) {
    const auto found = std::ranges::find(tables, name, [](const auto& each) { return each.first; });
    return found == tables.end() ? nullptr : &found->second;
  };
  print_areas(report, *find("plots"));
  print_text("Strata, with standard errors over plots\n");
  print_estimates(
      report, {{"stratum", "stratum", 0, "", "(none)"}, {"plots", "plots", 0}}, *find("strata"));
  if (const data::Table* domains = find("domains")) {
    Shown labels;
    for (const std::string& name : report.by) labels.push_back({name, name, 0, "", "(none)"});
    print_text("Trees by {}, with standard errors over plots\n", fmt::join(report.by, " and "));
    data::Table rows = *domains;
    std::vector<double> areas;
    for (const stand::DomainFigures& one : report.domains) areas.push_back(one.figures.area_ha);
    rows.set("area_ha", std::move(areas));
    print_estimates(report, labels, rows);
  }
  print_species(report, *find("species"));
  print_diameters(report);
  if (const data::Table* thinning = find("thinning")) print_thinning(*thinning);
  if (const data::Table* sites = find("sites")) print_sites(*sites);
  if (const data::Table* means = find("structure")) {
    print_structure(*means, report.units->neighbors);
  }
  print_joint(report);
}

/// \param tables  of the report
void print_growth(const stand::GrowthReport& report, const Tables& tables) {
  print_fates(report);
  const TitledParts parts = parts_of(report);
  for (std::size_t value = 0; value < report.values.size(); ++value) {
    print_growth_of_plots(report.values[value], parts, tables[1].second);
    print_growth_of_strata(report, parts, value);
  }
}

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
  std::ostringstream sheet;
  const auto write = [&](const stand::CheckedInventory& part, const stand::StructuralUnits& units) {
    if (arguments.out.empty()) return;
    if (is_folder(arguments.out) && !folder) folder.emplace(arguments.out);
    if (!rows && folder) {
      rows.emplace((std::filesystem::path(arguments.out) / "indices.csv").string());
    } else if (!rows) {
      rows.emplace(&sheet);
    }
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
  if (rows) rows->finish();
  Tables tables = study::tables_of(summary);
  if (rows && !folder) {
    tables.emplace_back("indices", table_of_csv(std::move(sheet).str(), arguments.out, {}));
  }
  if (!arguments.out.empty()) write_tables(arguments.out, tables);
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
                                             "structure.csv",
                                             "classes.csv",
                                             "indices.csv",
                                             "growth_trees.csv",
                                             "growth_plots.csv",
                                             "growth_strata.csv"});
  if (is_layer_output(arguments.out)) written = {{"--out", arguments.out}};
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
