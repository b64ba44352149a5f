// SPDX-License-Identifier: MIT
// silvafit indices: the structural unit of every tree of an inventory.
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "inventory_options.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct IndicesArguments {
  InventoryArguments inventory{};
  UnitArguments units{};
  std::string out{};
  std::string excluded{};
  CommonOptions common{};
};

struct Seconds {
  double units = 0.0;  ///< structural units alone
  double all = 0.0;    ///< with reading and writing
};

ordered_json number_or_null(double value) {
  return std::isnan(value) ? ordered_json(nullptr) : ordered_json(value);
}

ordered_json summary_json(const stand::UnitSummary& summary, const stand::StructuralUnits& units) {
  ordered_json result{{"trees", summary.trees},
                      {"core", summary.core_trees},
                      {"W", number_or_null(summary.W)},
                      {"M", number_or_null(summary.M)},
                      {"U", number_or_null(summary.U)},
                      {"C", number_or_null(summary.C)}};
  for (std::size_t i = 0; i < units.further.size(); ++i) {
    result[std::string(stand::name_of(units.further[i].index))] =
        number_or_null(summary.further[i]);
  }
  return result;
}

ordered_json result_json(const IndicesArguments& arguments,
                         const stand::CheckedInventory& checked,
                         const stand::StructuralUnits& units,
                         const Seconds& seconds) {
  ordered_json species = ordered_json::object();
  for (const auto& summary : stand::summarize_by_species(checked.inventory, units)) {
    species[summary.species] = summary_json(summary, units);
  }
  ordered_json notes = checked.notes;
  for (const std::string& note : units.notes) notes.push_back(note);
  return {{"schema", "silvafit-indices/1"},
          {"silvafit", version()},
          {"inventory", arguments.inventory.path},
          {"excluded", checked.excluded_tree_count},
          {"neighbors", units.neighbors},
          {"alpha_deg", units.alpha0_deg},
          {"edge", arguments.units.edge},
          {"buffer_m",
           arguments.units.edge == "buffer" ? ordered_json(arguments.units.buffer_m)
                                            : ordered_json(nullptr)},
          {"per", arguments.units.per},
          {"all", summary_json(stand::summarize_all(checked.inventory, units), units)},
          {"species", std::move(species)},
          {"notes", std::move(notes)},
          {"seconds", seconds.all},
          {"seconds_units", seconds.units}};
}

void write_units(const IndicesArguments& arguments,
                 const stand::Inventory& inventory,
                 const stand::StructuralUnits& units) {
  if (!arguments.out.empty()) {
    AtomicFile file(arguments.out);
    stand::write_structural_units(inventory, units, file.stream());
    file.commit();
  } else if (!arguments.common.json) {
    stand::write_structural_units(inventory, units, std::cout);
    std::cout.flush();
    if (!std::cout) throw InputError("writing to standard output failed");
  }
}

void run(const IndicesArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const auto elapsed_since = [](std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const stand::StructuralUnitOptions options = unit_options(arguments.units, arguments.common);
  const stand::CheckedInventory checked =
      read_inventory(arguments.inventory, {.needs_coordinates = true}, arguments.common);
  if (!arguments.excluded.empty()) stand::write_excluded(checked.excluded, arguments.excluded);
  Seconds seconds;
  const auto units_start = std::chrono::steady_clock::now();
  const stand::StructuralUnits units = stand::structural_units(checked.inventory, options);
  seconds.units = elapsed_since(units_start);
  for (const std::string& note : units.notes) say(arguments.common, "note: " + note);
  write_units(arguments, checked.inventory, units);
  seconds.all = elapsed_since(start);
  if (arguments.common.json) {
    const ordered_json result = result_json(arguments, checked, units, seconds);
    fmt::print("{}\n", result.dump(2));
  }
}

}  // namespace

void add_indices_command(CLI::App& program) {
  const auto arguments = std::make_shared<IndicesArguments>();
  CLI::App& command =
      *program.add_subcommand("indices", "W, M, U and C of every tree, from its nearest neighbors");
  add_inventory_options(command, arguments->inventory);
  add_unit_options(command, arguments->units);
  command.add_option("--out", arguments->out, "CSV file to write (default: standard output)")
      ->type_name("FILE.csv");
  command
      .add_option("--excluded", arguments->excluded, "Where to write the rows left out, and why")
      ->type_name("FILE.csv");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit indices examples/fir-mixed/inventory.csv --per stand --out indices.csv");
  command.callback([arguments] { run(*arguments); });
}

}  // namespace silvafit::cli
