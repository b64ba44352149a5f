// SPDX-License-Identifier: MIT
#include "inventory_options.hpp"

#include <algorithm>

namespace silvafit::cli {
namespace {

void add_window_options(CLI::App& command, study::UnitSettings& settings) {
  command
      .add_option("--edge",
                  settings.edge,
                  "Edge correction: buffer (trees near the boundary are neighbors only), hanisch "
                  "(core trees are those whose neighbors are nearer than the boundary, with "
                  "weights), torus (opposite sides are joined) or none")
      ->check(CLI::IsMember({"buffer", "hanisch", "torus", "none"}))
      ->capture_default_str();
  command.add_option("--buffer", settings.buffer_m, "Width of the buffer in m")
      ->capture_default_str();
  CLI::Option* window =
      command
          .add_option(
              "--window",
              settings.window,
              "Area of the inventory in m: GeoJSON, WKT, or CSV with plot and wkt, or plot, "
              "x, y and radius; or a layer of polygons (default: the convex hull of the trees)")
          ->type_name("FILE");
  command
      .add_option("--circle",
                  settings.circle,
                  "The boundary of every plot is this circle, in coordinates of the plot, such as "
                  "0,0,12.62")
      ->type_name("X,Y,RADIUS")
      ->excludes(window);
  command.add_option("--per", settings.per, "Search neighbors within each plot or the whole stand")
      ->check(CLI::IsMember({"plot", "stand"}))
      ->capture_default_str();
}

}  // namespace

CLI::Option* add_columns_option(CLI::App& command,
                                study::ReadingSettings& settings,
                                const std::string& help) {
  return command.add_option("--columns", settings.columns, help)
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
}

void add_missing_option(CLI::App& command, study::ReadingSettings& settings) {
  command
      .add_option("--missing",
                  settings.missing,
                  "Further texts or numbers for missing values, such as -88,unknown (known are "
                  "empty fields, NA, -, n/a and similar, -999, and 0 in dbh, h and cw)")
      ->delimiter(',')
      ->type_name("CODE,...")
      ->allow_extra_args(false);
}

void add_fill_down_option(CLI::App& command, study::ReadingSettings& settings) {
  command
      .add_option(
          "--fill-down",
          settings.fill_down,
          "Columns whose empty fields have the value above, as in exported merged cells, such "
          "as plot,species")
      ->delimiter(',')
      ->type_name("COLUMN,...")
      ->allow_extra_args(false);
}

void add_sheet_options(CLI::App& command, study::ReadingSettings& settings) {
  add_missing_option(command, settings);
  add_fill_down_option(command, settings);
  command.add_flag("--case-sensitive",
                   settings.case_sensitive,
                   "Species that differ only in capitals, accents or blanks are different");
}

void add_dead_option(CLI::App& command, study::ReadingSettings& settings) {
  command
      .add_option("--dead",
                  settings.dead,
                  "Standing dead trees, by a column of the status: leave-out; neighbors (they are "
                  "neighbors of living trees, but not in summaries or models); include (as living "
                  "ones; cut and fallen trees, too)")
      ->check(CLI::IsMember({"leave-out", "neighbors", "include"}))
      ->capture_default_str();
  const auto add_codes = [&command](
                             const char* name, std::vector<std::string>& codes, const char* help) {
    command.add_option(name, codes, help)
        ->delimiter(',')
        ->type_name("CODE,...")
        ->allow_extra_args(false);
  };
  add_codes("--alive-codes", settings.alive_codes, "Values of the status that mean alive");
  add_codes(
      "--dead-codes", settings.dead_codes, "Values of the status that mean dead and standing");
  add_codes(
      "--cut-codes", settings.cut_codes, "Values of the status that mean cut, fallen or a stump");
}

void add_trust_units_option(CLI::App& command, study::ReadingSettings& settings) {
  command.add_flag("--trust-units",
                   settings.trust_units,
                   "Do not check whether a column, or some plots, have another unit");
}

void add_inventory_options(CLI::App& command,
                           std::string& inventory,
                           study::ReadingSettings& settings,
                           TableArguments& table) {
  command
      .add_option("inventory",
                  inventory,
                  "Inventory with one row per tree: a CSV file; a workbook (xlsx, ods, xls), a GIS "
                  "layer of points (gpkg, shp, fgb, geojson), SQLite or PG:dbname=...")
      ->type_name("INVENTORY.csv")
      ->required();
  add_layer_options(command, table);
  add_columns_option(
      command, settings, "Names or formulas of the columns, such as dbh=DBH_cm,h=Height,x=xk/10");
  add_trust_units_option(command, settings);
  add_sheet_options(command, settings);
  add_dead_option(command, settings);
}

void add_sampling_options(CLI::App& command,
                          study::SamplingSettings& settings,
                          PlotsArgument& plots) {
  CLI::Option* const file =
      command
          .add_option("--plots",
                      plots.file,
                      "Table of plots, joined by the column plot: area in m2 or radius in m, "
                      "stratum, share, slope, x, y and others; CSV, workbook, layer or database")
          ->type_name("FILE");
  CLI::Option* const layer =
      command.add_option("--plots-layer", plots.choice.layer, "Sheet or layer of --plots")
          ->type_name("NAME")
          ->needs(file);
  command.add_option("--plots-sql", plots.choice.sql, "Query that makes the table of plots")
      ->type_name("QUERY")
      ->needs(file)
      ->excludes(layer);
  command
      .add_option("--plots-columns",
                  settings.plots_columns,
                  "Names or formulas of the columns of --plots, such as area=SIZE*100")
      ->type_name("NAME=COLUMN,...")
      ->needs(file)
      ->allow_extra_args(false);
  command
      .add_option("--circles",
                  settings.circles,
                  "Concentric circles: from which dbh in cm trees are counted up to which radius "
                  "in m, such as 7=4,15=8,30=12")
      ->delimiter(',')
      ->type_name("DBH=RADIUS,...");
  CLI::Option* const angle =
      command
          .add_option("--angle-count",
                      settings.angle_count,
                      "Plots are angle counts with this basal area factor in m2/ha")
          ->check(CLI::PositiveNumber)
          ->type_name("FACTOR");
  command
      .add_option("--smallest-dbh",
                  settings.smallest_dbh_cm,
                  "Angle counts: smallest dbh that is counted in cm (default: the smallest dbh)")
      ->check(CLI::PositiveNumber)
      ->type_name("CM")
      ->needs(angle);
  command
      .add_option("--expansion",
                  settings.expansion,
                  "Column with the number of trees per ha that each tree stands for")
      ->type_name("COLUMN");
  command
      .add_option("--expansion-area",
                  settings.expansion_area,
                  "Hectares of --expansion are those of the whole plot (plot), so that values are "
                  "divided by its share, or of the part in the population (part)")
      ->check(CLI::IsMember({"plot", "part"}))
      ->capture_default_str();
  command
      .add_option("--subplots", settings.subplots, "Number of circles of a plot, all of one kind")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      .add_option("--subplot",
                  settings.subplot,
                  "Column with the subplot of each tree, within which neighbors are searched")
      ->type_name("COLUMN");
  command.add_flag("--slope-correction",
                   settings.slope_correction,
                   "Distances of plots were measured along the slope of --plots");
}

void add_equation_options(CLI::App& command, study::EquationSettings& settings) {
  CLI::Option* const equations =
      command
          .add_option("--equations",
                      settings.equations,
                      "Equations of volume, biomass and carbon, for all or single species, such as "
                      "laasasenaho-pine,B=taper; taper is the volume by the taper equation that "
                      "trees are drawn with (silvafit models --equations lists them)")
          ->delimiter(',')
          ->type_name("[SPECIES=]ID,...");
  command
      .add_option("--equation-file",
                  settings.files,
                  "File of further equations (JSON, schema silvafit-tree-equations/1)")
      ->type_name("FILE.json")
      ->needs(equations)
      ->allow_extra_args(false);
}

void open_plots(const PlotsArgument& plots,
                const TreeTable& trees,
                const CommonOptions& common,
                study::SamplingSettings& settings) {
  if (plots.file.empty()) return;
  settings.plots = open_further_table(plots.file, plots.choice, trees, common);
}

void add_unit_options(CLI::App& command, study::UnitSettings& settings) {
  command.add_option("--neighbors", settings.neighbors, "Number of neighbors in a structural unit")
      ->capture_default_str();
  command
      .add_option(
          "--alpha",
          settings.alpha,
          "Limit angle of W in degrees (default: 360 / (neighbors + 1)), for single species "
          "as in 72,SM=60")
      ->delimiter(',')
      ->type_name("ANGLE,SPECIES=ANGLE,...");
  add_window_options(command, settings);
  command.add_option("--dominance", settings.dominance, "Size that U and T compare: dbh, h or cw")
      ->check(CLI::IsMember({"dbh", "h", "cw"}))
      ->capture_default_str();
  command
      .add_option("--crowding",
                  settings.crowding,
                  "Crowns in C: mean (half of cw) or facing (radii towards each other)")
      ->check(CLI::IsMember({"mean", "facing"}))
      ->capture_default_str();
  command
      .add_option(
          "--further",
          settings.further,
          "Further indices: CO crown overlap, T size differentiation, Hegyi, BAL basal area "
          "of larger trees, CCF crown competition factor; or all")
      ->delimiter(',')
      ->type_name("INDEX,...");
  command
      .add_option("--competition-radius",
                  settings.competition_radius_m,
                  "Hegyi: competitors are the trees within this radius in m (default: the "
                  "neighbors)")
      ->type_name("M");
  command
      .add_option("--open-grown",
                  settings.open_grown,
                  "CCF: crown width in m of an open-grown tree, such as \"0.9 + 0.22*dbh\"")
      ->type_name("EXPRESSION");
}

void refuse_idle_unit_options(const CLI::App& command,
                              const study::UnitSettings& settings,
                              const std::vector<stand::FurtherIndex>& further) {
  const auto is_made = [&further](stand::FurtherIndex index) {
    return std::ranges::find(further, index) != further.end();
  };
  refuse_idle(command, "--buffer", settings.edge == "buffer", "--edge buffer");
  refuse_idle(
      command, "--competition-radius", is_made(stand::FurtherIndex::kHegyi), "--further Hegyi");
  refuse_idle(
      command, "--open-grown", is_made(stand::FurtherIndex::kCrownCompetition), "--further CCF");
}

}  // namespace silvafit::cli
