// SPDX-License-Identifier: MIT
// silvafit indices: the structural unit of every tree of an inventory.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "command.hpp"
#include "inventory_options.hpp"
#include "output_files.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/stand/structural_units.hpp"
#include "silvafit/stand/unit_summary.hpp"
#include "standard_output.hpp"
#include "unit_summary_json.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct IndicesArguments {
  InventoryArguments inventory{};
  UnitArguments units{};
  std::string out{};
  std::string excluded{};
  bool stream = false;
  CommonOptions common{};
};

struct Seconds {
  double units = 0.0;  ///< structural units alone
  double all = 0.0;    ///< with reading and writing
};

/// Results of an inventory, accumulated batch by batch.
struct Outcome {
  stand::UnitSummaries summaries{};
  std::vector<std::string> notes{};
  std::vector<std::string> recognized{};  ///< of the notes, how the file was read
  std::size_t excluded_trees = 0;
  double alpha0_deg = 0.0;
  std::vector<stand::FurtherIndex> further{};
  Seconds seconds{};
  /// Parts of the inventory, whose notes are made at the end.
  stand::UnitFindings findings{};
};

ordered_json result_json(const IndicesArguments& arguments, const Outcome& outcome) {
  ordered_json species = ordered_json::object();
  for (const auto& summary : outcome.summaries.by_species()) {
    species[summary.species] = unit_summary_json(summary, outcome.further);
  }
  return {{"schema", "silvafit-indices/1"},
          {"silvafit", version()},
          {"inventory", arguments.inventory.path},
          {"excluded", outcome.excluded_trees},
          {"neighbors", arguments.units.neighbors},
          {"alpha_deg", outcome.alpha0_deg},
          {"edge", arguments.units.edge},
          {"buffer_m",
           arguments.units.edge == "buffer" ? ordered_json(arguments.units.buffer_m)
                                            : ordered_json(nullptr)},
          {"per", arguments.units.per},
          {"all", unit_summary_json(outcome.summaries.all(), outcome.further)},
          {"species", std::move(species)},
          {"recognized", outcome.recognized},
          {"notes", outcome.notes},
          {"seconds", outcome.seconds.all},
          {"seconds_units", outcome.seconds.units}};
}

/// Target of the table of units: a file, standard output or, with --json alone, none.
class UnitTable {
 public:
  explicit UnitTable(const IndicesArguments& arguments) {
    if (!arguments.out.empty()) {
      file_.emplace(arguments.out);
      stream_ = &file_->stream();
    } else if (!arguments.common.json) {
      stream_ = &std::cout;
    }
  }

  void write(const stand::Inventory& inventory, const stand::StructuralUnits& units) {
    if (stream_ == nullptr) return;
    stand::write_structural_units(inventory, units, *stream_, is_first_);
    is_first_ = false;
  }

  void finish() {
    if (file_) file_->commit();
    if (stream_ == &std::cout) finish_standard_output();
  }

 private:
  std::optional<AtomicFile> file_{};
  std::ostream* stream_ = nullptr;
  bool is_first_ = true;
};

/// The file of skipped rows, if one is wanted.
class ExcludedFile {
 public:
  explicit ExcludedFile(const IndicesArguments& arguments) {
    if (!arguments.excluded.empty()) file_.emplace(arguments.excluded);
  }

  void write(const std::vector<stand::ExcludedRow>& rows) {
    if (!file_) return;
    stand::write_excluded(rows, file_->stream(), is_first_);
    is_first_ = false;
  }

  void finish() {
    write({});  // at least the header
    if (file_) file_->commit();
  }

 private:
  std::optional<AtomicFile> file_{};
  bool is_first_ = true;
};

/// Where the rows of an inventory go: those of its trees and those that are skipped.
struct Tables {
  explicit Tables(const IndicesArguments& arguments) : units(arguments), excluded(arguments) {}

  UnitTable units;
  ExcludedFile excluded;
};

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// The units of one inventory or batch, written and summed up.
void take(const stand::CheckedInventory& checked,
          const stand::StructuralUnitOptions& options,
          Tables& tables,
          Outcome& outcome) {
  outcome.excluded_trees += checked.excluded_tree_count;
  tables.excluded.write(checked.excluded);
  if (checked.inventory.size() == 0) return;
  const auto start = std::chrono::steady_clock::now();
  const stand::StructuralUnits units = stand::structural_units(checked.inventory, options);
  outcome.seconds.units += seconds_since(start);
  outcome.findings.add(units.findings);
  outcome.alpha0_deg = units.alpha0_deg;
  outcome.summaries.add(checked.inventory, units);
  tables.units.write(checked.inventory, units);
}

void take_batches(const IndicesArguments& arguments,
                  stand::StructuralUnitOptions options,
                  Tables& tables,
                  Outcome& outcome) {
  if (options.scope == stand::SearchScope::kStand) {
    throw UsageError("--stream cannot search neighbors across plots; use --per plot",
                     {.column = "--stream"});
  }
  constexpr std::size_t kTreesOfBatch = 200000;
  stand::InventoryBatches batches(arguments.inventory.path,
                                  reading_options(arguments.inventory, {.needs_coordinates = true}),
                                  kTreesOfBatch);
  options.is_part = true;
  Progress progress(arguments.common);
  std::size_t trees = 0;
  while (const auto batch = batches.next()) {
    take(*batch, options, tables, outcome);
    trees += batch->inventory.size();
    progress.show(fmt::format("{} trees", trees), 0, 1);
  }
  std::vector<std::string> species;
  for (const auto& summary : outcome.summaries.by_species()) species.push_back(summary.species);
  std::erase(species, "");
  stand::check_species_of_angles(options, species, arguments.inventory.path);
  outcome.notes = batches.notes();
  outcome.recognized = batches.recognized();
  for (const std::string& note : outcome.notes) say(arguments.common, "note: " + note);
  const std::string excluded = batches.excluded();
  if (!excluded.empty()) say(arguments.common, "note: " + excluded);
}

/// The notes on the units of all parts.
void say_findings(const IndicesArguments& arguments,
                  const stand::StructuralUnitOptions& options,
                  Outcome& outcome) {
  const auto notes = stand::notes_of(outcome.findings, options, arguments.inventory.path);
  for (const std::string& note : notes) {
    say(arguments.common, "note: " + note);
    outcome.notes.push_back(note);
  }
}

void run(const IndicesArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  refuse_same_files(
      {{"INVENTORY.csv", arguments.inventory.path}, {"--window", arguments.units.window}},
      {{"--out", arguments.out}, {"--excluded", arguments.excluded}});
  const stand::StructuralUnitOptions options = unit_options(arguments.units, arguments.common);
  Tables tables(arguments);
  Outcome outcome{.further = options.further};
  std::ranges::sort(outcome.further);
  // Not std::ranges::unique, because clang 14 does not support structured bindings of its result.
  outcome.further.erase(std::unique(outcome.further.begin(), outcome.further.end()),
                        outcome.further.end());
  if (arguments.stream) {
    take_batches(arguments, options, tables, outcome);
  } else {
    const stand::CheckedInventory checked =
        read_inventory(arguments.inventory, {.needs_coordinates = true}, arguments.common);
    outcome.notes = checked.notes;
    outcome.recognized = checked.recognized;
    take(checked, options, tables, outcome);
  }
  say_findings(arguments, options, outcome);
  const stand::UnitSummary all = outcome.summaries.all();
  if (all.core_trees < all.trees) {
    say(arguments.common,
        fmt::format("note: {} of {} trees are core trees; {} are near the boundary or have no "
                    "structural unit",
                    all.core_trees,
                    all.trees,
                    all.trees - all.core_trees));
  }
  tables.excluded.finish();
  tables.units.finish();
  outcome.seconds.all = seconds_since(start);
  if (arguments.common.json) print_json_value(result_json(arguments, outcome));
}

}  // namespace

void add_indices_command(CLI::App& program) {
  const auto arguments = std::make_shared<IndicesArguments>();
  CLI::App& command = *program.add_subcommand(
      "indices", "Compute W, M, U and C of every tree from its nearest neighbors");
  add_inventory_options(command, arguments->inventory);
  add_unit_options(command, arguments->units);
  command.add_option("--out", arguments->out, "CSV file to write (default: standard output)")
      ->type_name("FILE.csv");
  command
      .add_option("--excluded",
                  arguments->excluded,
                  "Write the skipped rows, with the reason, to this CSV file")
      ->type_name("FILE.csv");
  command.add_flag("--stream",
                   arguments->stream,
                   "Read plot by plot, so that memory does not grow with the file; the rows of a "
                   "plot must be contiguous");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit indices examples/fir-mixed/inventory.csv --per stand --out indices.csv");
  command.callback([arguments, &command] {
    refuse_idle_unit_options(command, arguments->units, further_indices(arguments->units));
    run(*arguments);
  });
}

}  // namespace silvafit::cli
