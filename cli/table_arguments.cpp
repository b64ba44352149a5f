// SPDX-License-Identifier: MIT
#include "table_arguments.hpp"

#include <memory>
#include <utility>

#include "help.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/source/open_raster.hpp"
#include "silvafit/stand/window.hpp"

namespace silvafit::cli {
namespace {

void print_notes(const source::OpenedTable& opened, const CommonOptions& common) {
  for (const std::string& note : opened.notes) {
    say(common, "note: " + describe({.file = data::file_of(opened.table)}, note));
  }
}

}  // namespace

void add_layer_options(CLI::App& command, TableArguments& arguments) {
  CLI::Option* const layer =
      command
          .add_option("--layer",
                      arguments.choice.layer,
                      "Sheet of a workbook, layer of a GIS file or table of a database (default: "
                      "the only one)")
          ->type_name("NAME")
          ->group(kInputSection);
  command
      .add_option("--sql",
                  arguments.choice.sql,
                  "Query that makes the table, such as \"select * from trees where year = 2024\"")
      ->type_name("QUERY")
      ->excludes(layer)
      ->group(kInputSection);
  command
      .add_flag("--allow-network",
                arguments.choice.allow_network,
                "Files may be addresses of the network (https://, /vsicurl/)")
      ->group(kInputSection);
}

void add_window_layer_option(CLI::App& command, TableArguments& arguments) {
  command
      .add_option("--window-layer",
                  arguments.window_layer,
                  "Layer of --window (default: its only layer of polygons)")
      ->type_name("NAME")
      ->needs(command.get_option("--window"))
      ->group("Structural units");
}

void add_terrain_option(CLI::App& command, TableArguments& arguments) {
  command
      .add_option(
          "--terrain",
          arguments.terrain,
          "Terrain model (GeoTIFF or ASCII grid, in meters and the trees' coordinates) that "
          "the trees stand on, instead of their column z")
      ->type_name("FILE.tif")
      ->group(kInputSection);
}

TreeTable open_drawn_trees(const std::string& name,
                           const TableArguments& arguments,
                           study::ReadingSettings& reading,
                           const CommonOptions& common) {
  TreeTable trees = open_trees(name, arguments, common);
  if (!arguments.terrain.empty()) {
    reading.terrain = std::make_shared<const data::Raster>(
        source::open_raster(arguments.terrain, trees.coordinates));
  }
  return trees;
}

TreeTable open_trees(const std::string& name,
                     const TableArguments& arguments,
                     const CommonOptions& common) {
  source::OpenedTable opened = source::open_table(name, arguments.choice);
  print_notes(opened, common);
  return {.table = std::move(opened.table), .coordinates = std::move(opened.coordinates)};
}

data::TableSource open_further_table(const std::string& name,
                                     const source::TableChoice& choice,
                                     const TreeTable& trees,
                                     const CommonOptions& common) {
  source::OpenedTable opened =
      source::open_table(name, choice, source::GeometryUse::kPositions, trees.coordinates);
  print_notes(opened, common);
  return std::move(opened.table);
}

TreeTable open_inventory(const std::string& name,
                         const TableArguments& arguments,
                         study::UnitSettings& units,
                         const CommonOptions& common) {
  TableArguments trees = arguments;
  // GeoJSON has a separate reader without GDAL; coordinates of a layer may need GDAL.
  const bool is_layer = source::is_layered(units.window);
  if (is_layer && !source::is_layered(name)) {
    if (trees.window_layer.empty()) trees.window_layer = trees.choice.layer;
    trees.choice.layer.clear();
  }
  TreeTable opened = open_trees(name, trees, common);
  const bool is_geojson = units.window.ends_with("json");
  if (!is_layer || (is_geojson && !opened.coordinates)) {
    if (arguments.window_layer.empty()) return opened;
    throw UsageError("the file of --window has no layers", {.column = "--window-layer"});
  }
  const source::TableChoice choice{.layer = trees.window_layer,
                                   .allow_network = trees.choice.allow_network};
  const source::OpenedTable windows =
      source::open_table(units.window, choice, source::GeometryUse::kAreas, opened.coordinates);
  print_notes(windows, common);
  units.windows = stand::windows_of_table(windows.table);
  return opened;
}

}  // namespace silvafit::cli
