// SPDX-License-Identifier: MIT
// Tables of commands: CSV files, and with GDAL sheets, layers and results of queries.
#pragma once

#include <optional>
#include <string>

#include "command.hpp"
#include "silvafit/source/open_table.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::cli {

/// The choice of a table of a file.
struct TableArguments {
  source::TableChoice choice{};
  std::string window_layer{};
  std::string terrain{};
};

/// A table, and its coordinate reference system if that is known.
struct TreeTable {
  data::TableSource table{};
  std::optional<source::CoordinateSystem> coordinates{};
};

/// Adds --layer, --sql and --allow-network.
void add_layer_options(CLI::App& command, TableArguments& arguments);

/// Adds --window-layer.
void add_window_layer_option(CLI::App& command, TableArguments& arguments);

/// Adds --terrain.
void add_terrain_option(CLI::App& command, TableArguments& arguments);

/// Opens the trees of a command that draws them, and reads the terrain that they stand on.
TreeTable open_drawn_trees(const std::string& name,
                           const TableArguments& arguments,
                           study::ReadingSettings& reading,
                           const CommonOptions& common);

/// Opens the trees of a command, with notes on standard error.
/// \throws as source::open_table
TreeTable open_trees(const std::string& name,
                     const TableArguments& arguments,
                     const CommonOptions& common);

/// Opens another table of a command, in the coordinates of the trees if both are known.
data::TableSource open_further_table(const std::string& name,
                                     const source::TableChoice& choice,
                                     const TreeTable& trees,
                                     const CommonOptions& common);

/// Opens the trees, and reads the windows of --window if they are a layer, in the coordinates of
/// the trees. If the trees are a CSV file, --layer is the layer of the windows.
/// \param units  gets the windows
TreeTable open_inventory(const std::string& name,
                         const TableArguments& arguments,
                         study::UnitSettings& units,
                         const CommonOptions& common);

}  // namespace silvafit::cli
