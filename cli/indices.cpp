// SPDX-License-Identifier: MIT
// silvafit indices: the structural unit of every tree of an inventory.
#include "silvafit/study/indices.hpp"

#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "help.hpp"
#include "output_files.hpp"
#include "row_output.hpp"
#include "setting_options.hpp"
#include "shared_options.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/study/study_files.hpp"
#include "standard_output.hpp"
#include "table_output.hpp"

namespace silvafit::cli {
namespace {

struct IndicesArguments {
  std::string inventory{};
  study::IndicesOptions options{};
  std::string out{};
  std::string excluded{};
  TableArguments table{};
  source::TableChoice plots{};
  CommonOptions common{};
};

void run(const IndicesArguments& arguments) {
  refuse_same_files({{"INVENTORY.csv", arguments.inventory},
                     {"--window", arguments.options.units.window},
                     {"--plots", arguments.options.sampling.plots_file}},
                    {{"--out", arguments.out}, {"--excluded", arguments.excluded}});
  study::IndicesOptions options = arguments.options;
  if (options.stream && is_layer_output(arguments.out)) {
    throw UsageError("writes CSV only, because a layer is written as a whole",
                     {.column = "--stream"});
  }
  options.threads = arguments.common.threads;
  // A layer gets the columns of the inventory, too, and the plots as a layer of their own.
  const bool is_layer = is_layer_output(arguments.out);
  require_table_output(arguments.out);
  RowOutput excluded(arguments.excluded);
  RowOutput rows =
      is_layer ? RowOutput(nullptr) : file_or_standard_output(arguments.out, arguments.common);
  const TreeTable trees =
      open_inventory(arguments.inventory, arguments.table, options.units, arguments.common);
  open_plots(arguments.plots, trees, arguments.common, options.sampling);
  const auto write = [&](const stand::CheckedInventory& checked,
                         const stand::StructuralUnits& units) {
    const stand::Inventory& inventory = checked.inventory;
    if (excluded.begin(stand::kExcludedHeader, checked.is_in_file_order)) {
      for (const auto& row : checked.excluded) excluded.add(row.line, stand::csv_text(row));
    }
    if (inventory.size() == 0) return;
    if (is_layer) {
      write_trees(arguments.out,
                  study::inventory_table(inventory, units),
                  plot_layer(inventory, units.windows),
                  trees.coordinates,
                  arguments.common);
    }
    if (!rows.begin(stand::header_of_units(units), checked.is_in_file_order)) return;
    stand::write_structural_units(inventory, units, [&](std::size_t tree, std::string_view text) {
      rows.add(inventory.lines[tree], text);
    });
  };
  Progress progress(arguments.common);
  const study::IndicesSummary summary =
      study::compute_indices(trees.table, options, write, callbacks(arguments.common, progress));
  progress.clear();
  excluded.finish();
  rows.finish();
  if (arguments.common.json) print_json_value(study::json_of(summary));
}

}  // namespace

void add_indices_command(CLI::App& program) {
  const auto arguments = std::make_shared<IndicesArguments>();
  CLI::App& command = *program.add_subcommand(
      "indices", "Compute W, M, U and C of every tree from its nearest neighbors");
  add_inventory_options(
      command, arguments->inventory, arguments->options.reading, arguments->table);
  add_unit_options(command, arguments->options.units);
  add_window_layer_option(command, arguments->table);
  add_sampling_options(command, arguments->options.sampling, arguments->plots);
  add_output_option(command, "--out", arguments->out, kTableOutputHelp);
  add_output_option(command,
                    "--excluded",
                    arguments->excluded,
                    "Write the skipped rows, with the reason, to this CSV file",
                    "FILE.csv");
  command.add_flag(
      "--stream",
      arguments->options.stream,
      "Read plot by plot, so that memory does not grow with the file; if the rows of a "
      "plot are not contiguous, they are sorted on disk first");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit indices examples/fir-mixed/inventory.csv --per stand --out indices.csv");
  command.callback([arguments, &command] {
    study::refuse_idle(arguments->options, given_options(command));
    run(*arguments);
  });
}

}  // namespace silvafit::cli
