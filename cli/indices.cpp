// SPDX-License-Identifier: MIT
// silvafit indices: the structural unit of every tree of an inventory.
#include "silvafit/study/indices.hpp"

#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "command.hpp"
#include "help.hpp"
#include "inventory_options.hpp"
#include "output_files.hpp"
#include "silvafit/base/atomic_file.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/data/ordered_rows.hpp"
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

/// Target of the table of units: a file, standard output or, with --json alone, none. A layer gets
/// the columns of the inventory, too, and the plots as a layer of their own.
class UnitTable {
 public:
  explicit UnitTable(const IndicesArguments& arguments) : arguments_(arguments) {
    if (is_layer_output(arguments.out)) {
      require_table_output(arguments.out);
    } else if (!arguments.out.empty()) {
      file_.emplace(arguments.out);
      stream_ = &file_->stream();
    } else if (!arguments.common.json) {
      stream_ = &std::cout;
    }
  }

  void write(const stand::Inventory& inventory,
             const stand::StructuralUnits& units,
             bool is_in_file_order,
             const std::optional<source::CoordinateSystem>& coordinates) {
    if (is_layer_output(arguments_.out)) {
      write_trees(arguments_.out,
                  study::inventory_table(inventory, units),
                  plot_layer(inventory, units.windows),
                  coordinates,
                  arguments_.common);
    }
    if (stream_ == nullptr) return;
    if (!rows_) {
      *stream_ << stand::header_of_units(units);
      rows_.emplace(*stream_, !is_in_file_order);
    }
    stand::write_structural_units(inventory, units, [&](std::size_t tree, std::string_view text) {
      rows_->add(inventory.lines[tree], text);
    });
  }

  void finish() {
    if (rows_) rows_->finish();
    if (file_) file_->commit();
    if (stream_ == &std::cout) finish_standard_output();
  }

 private:
  const IndicesArguments& arguments_;
  std::optional<AtomicFile> file_{};
  std::ostream* stream_ = nullptr;
  std::optional<data::OrderedRows> rows_{};
};

/// The file of skipped rows, if one is wanted.
class ExcludedFile {
 public:
  explicit ExcludedFile(const IndicesArguments& arguments) {
    if (!arguments.excluded.empty()) file_.emplace(arguments.excluded);
  }

  void write(const std::vector<stand::ExcludedRow>& rows, bool is_in_file_order) {
    if (!file_) return;
    if (!rows_) {
      stand::write_excluded({}, file_->stream());  // the header
      rows_.emplace(file_->stream(), !is_in_file_order);
    }
    for (const stand::ExcludedRow& row : rows) rows_->add(row.line, stand::csv_text(row));
  }

  void finish() {
    write({}, true);
    if (!file_) return;
    rows_->finish();
    file_->commit();
  }

 private:
  std::optional<AtomicFile> file_{};
  std::optional<data::OrderedRows> rows_{};
};

/// The outputs for the rows of an inventory: rows of trees, and skipped rows.
struct Tables {
  explicit Tables(const IndicesArguments& arguments) : units(arguments), excluded(arguments) {}

  UnitTable units;
  ExcludedFile excluded;
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
  Tables tables(arguments);
  const TreeTable trees =
      open_inventory(arguments.inventory, arguments.table, options.units, arguments.common);
  open_plots(arguments.plots, trees, arguments.common, options.sampling);
  const auto write = [&](const stand::CheckedInventory& checked,
                         const stand::StructuralUnits& units) {
    tables.excluded.write(checked.excluded, checked.is_in_file_order);
    if (checked.inventory.size() == 0) return;
    tables.units.write(checked.inventory, units, checked.is_in_file_order, trees.coordinates);
  };
  Progress progress(arguments.common);
  const study::IndicesSummary summary =
      study::compute_indices(trees.table, options, write, callbacks(arguments.common, progress));
  progress.clear();
  tables.excluded.finish();
  tables.units.finish();
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
  command.add_option("--out", arguments->out, kTableOutputHelp)
      ->type_name("FILE")
      ->group(kOutputSection);
  command
      .add_option("--excluded",
                  arguments->excluded,
                  "Write the skipped rows, with the reason, to this CSV file")
      ->type_name("FILE.csv")
      ->group(kOutputSection);
  command.add_flag(
      "--stream",
      arguments->options.stream,
      "Read plot by plot, so that memory does not grow with the file; if the rows of a "
      "plot are not contiguous, they are sorted on disk first");
  add_common_options(command, arguments->common);
  add_example(command,
              "silvafit indices examples/fir-mixed/inventory.csv --per stand --out indices.csv");
  command.callback([arguments, &command] {
    const study::UnitSettings& units = arguments->options.units;
    refuse_idle_unit_options(command, units, study::further_indices(units));
    run(*arguments);
  });
}

}  // namespace silvafit::cli
