// SPDX-License-Identifier: MIT
#include "inventory_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace silvafit::cli {

void add_inventory_options(CLI::App& command, InventoryArguments& arguments) {
  command.add_option("inventory", arguments.path, "Inventory: a CSV file, one row a tree")
      ->type_name("INVENTORY.csv")
      ->required();
  command
      .add_option("--columns",
                  arguments.columns,
                  "Where columns come from, such as dbh=DBH_cm,h=Height,x=xk/10")
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
  command.add_flag(
      "--trust-units", arguments.trust_units, "Do not ask whether a column has another unit");
}

void add_unit_options(CLI::App& command, UnitArguments& arguments) {
  command.add_option("--neighbors", arguments.neighbors, "Neighbors of a structural unit")
      ->capture_default_str();
  command.add_option("--alpha",
                     arguments.alpha_deg,
                     "Limit angle of W in degrees (default: 360 / (neighbors + 1))");
  command
      .add_option("--edge",
                  arguments.edge,
                  "Edge correction: trees near the boundary are neighbors only, or none")
      ->check(CLI::IsMember({"buffer", "none"}))
      ->capture_default_str();
  command.add_option("--buffer", arguments.buffer_m, "Width of the buffer in m")
      ->capture_default_str();
  command
      .add_option("--window",
                  arguments.window,
                  "Area of the inventory: polygons in m (default: the rectangle around the trees)")
      ->type_name("FILE.geojson");
  command
      .add_option("--per", arguments.per, "Search neighbors within each plot or the whole stand")
      ->check(CLI::IsMember({"plot", "stand"}))
      ->capture_default_str();
}

stand::CheckedInventory read_inventory(const InventoryArguments& arguments,
                                       stand::InventoryOptions options,
                                       const CommonOptions& common) {
  options.columns =
      stand::parse_column_mappings(fmt::format("{}", fmt::join(arguments.columns, ",")));
  options.trust_units = arguments.trust_units;
  stand::CheckedInventory checked = stand::read_inventory(arguments.path, options);
  for (const std::string& note : checked.notes) say(common, "note: " + note);
  const std::string excluded = stand::describe_excluded(checked);
  if (!excluded.empty()) say(common, "note: " + excluded);
  return checked;
}

stand::StructuralUnitOptions unit_options(const UnitArguments& arguments,
                                          const CommonOptions& common) {
  stand::StructuralUnitOptions options{
      .neighbors = arguments.neighbors,
      .alpha0_deg = arguments.alpha_deg,
      .edge =
          arguments.edge == "none" ? stand::EdgeCorrection::kNone : stand::EdgeCorrection::kBuffer,
      .buffer_m = arguments.buffer_m,
      .scope = arguments.per == "stand" ? stand::SearchScope::kStand : stand::SearchScope::kPlot,
      .threads = common.threads};
  if (!arguments.window.empty()) options.windows = stand::read_windows(arguments.window);
  return options;
}

}  // namespace silvafit::cli
