// SPDX-License-Identifier: MIT
// Options of the commands that read inventories and compute structural units.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command.hpp"
#include "sheet_options.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/study/unit_settings.hpp"

namespace silvafit::cli {

/// The inventory and how to read it.
struct InventoryArguments {
  std::string path{};
  std::vector<std::string> columns{};
  bool trust_units = false;
  SheetArguments sheet{};
};

/// How structural units are made.
struct UnitArguments {
  std::size_t neighbors = 4;
  std::vector<std::string> alpha{};  ///< "72" or "SM=60"
  std::string edge = "buffer";
  double buffer_m = 5.0;
  std::string window{};
  std::string circle{};  ///< "x,y,radius" of every plot
  std::string per = "plot";
  std::string dominance = "dbh";
  std::string crowding = "mean";
  std::vector<std::string> further{};  ///< names, or "all"
  double competition_radius_m = 0.0;
  std::string open_grown{};
};

/// Adds INVENTORY.csv, --columns, --trust-units and those of spreadsheets.
void add_inventory_options(CLI::App& command, InventoryArguments& arguments);

/// Adds --neighbors, --alpha, --edge, --buffer, --window, --circle, --per, --dominance, --crowding,
/// --further, --competition-radius and --open-grown.
void add_unit_options(CLI::App& command, UnitArguments& arguments);

/// The indices that --further asks for; "all" are those that nothing else is needed for, and CCF
/// only where --open-grown gives its crown widths.
std::vector<stand::FurtherIndex> further_indices(const UnitArguments& arguments);

/// Refuses --buffer, --competition-radius and --open-grown where nothing that is computed reads
/// them.
/// \param further  the further indices that are computed
void refuse_idle_unit_options(const CLI::App& command,
                              const UnitArguments& arguments,
                              const std::vector<stand::FurtherIndex>& further);

/// What the command needs of an inventory, with the options of add_inventory_options filled in.
stand::InventoryOptions reading_options(const InventoryArguments& arguments,
                                        stand::InventoryOptions options);

/// Reads the inventory; notes and rows left out are said on stderr.
/// \param options  what the command needs; the options of add_inventory_options are filled in here
stand::CheckedInventory read_inventory(const InventoryArguments& arguments,
                                       stand::InventoryOptions options,
                                       const CommonOptions& common);

/// The windows that were given, from their file or as a circle.
std::vector<stand::NamedWindow> given_windows(const UnitArguments& arguments);

/// The arguments that say what a study's settings do.
UnitArguments unit_arguments(const study::UnitSettings& settings);

/// The options of structural_units, with the windows read from their file.
stand::StructuralUnitOptions unit_options(const UnitArguments& arguments,
                                          const CommonOptions& common);

}  // namespace silvafit::cli
