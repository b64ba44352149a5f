// SPDX-License-Identifier: MIT
// silvafit columns: how each column of a table of trees is understood.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "command.hpp"
#include "shared_options.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/stand/described_columns.hpp"
#include "standard_output.hpp"
#include "text_table.hpp"

namespace silvafit::cli {
namespace {

using nlohmann::ordered_json;

struct ColumnsArguments {
  CommonOptions common{};
  TableArguments table{};
  std::string inventory{};
  study::ReadingSettings reading{};
};

std::string read_as(const stand::DescribedColumn& column) {
  if (column.read_as.empty()) return "-";
  std::string text = column.read_as;
  if (!column.unit.empty()) text += " [" + column.unit + "]";
  if (!column.source.empty()) text += " = " + column.source;
  return text;
}

std::string values_of(const stand::DescribedColumn& column) {
  if (!column.is_numeric) {
    const char* const more = column.different > column.examples.size() ? ", ..." : "";
    return fmt::format("{}: {}{}",
                       counted(column.different, "text", "texts"),
                       fmt::join(column.examples, ", "),
                       more);
  }
  if (std::isnan(column.lowest)) return "no value";
  std::string text = fmt::format("{:.6g} to {:.6g}", column.lowest, column.highest);
  if (column.impossible > 0) text += fmt::format(", {} impossible", column.impossible);
  return text;
}

ordered_json json_of(const stand::TableDescription& description) {
  ordered_json columns = ordered_json::array();
  for (const stand::DescribedColumn& column : description.columns) {
    ordered_json entry{{"column", column.name},
                       {"read_as", text_or_null(column.read_as)},
                       {"source", text_or_null(column.source)},
                       {"unit", text_or_null(column.unit)},
                       {"missing", column.missing}};
    if (column.is_numeric) {
      entry["lowest"] = number_or_null(column.lowest);
      entry["highest"] = number_or_null(column.highest);
      entry["impossible"] = column.impossible;
    } else {
      entry["texts"] = column.different;
      entry["examples"] = column.examples;
    }
    columns.push_back(std::move(entry));
  }
  ordered_json lacks = ordered_json::object();
  for (const stand::LackingCommand& one : description.commands) lacks[one.command] = one.lacks;
  return {{"schema", "silvafit-columns/1"},
          {"silvafit", version()},
          {"file", description.file},
          {"rows", description.rows},
          {"columns", std::move(columns)},
          {"lacks", std::move(lacks)},
          {"notes", description.notes}};
}

void print(const stand::TableDescription& description) {
  print_text("{}: {} rows\n", description.file, description.rows);
  for (const std::string& note : description.notes) print_text("  {}\n", with_options(note));
  TextTable table({"column", "read as", "values", "missing"});
  for (const stand::DescribedColumn& column : description.columns) {
    table.add({column.name, read_as(column), values_of(column), std::to_string(column.missing)});
  }
  table.print();
  for (const stand::LackingCommand& one : description.commands) {
    print_text("{}: {}{}\n",
               one.command,
               one.lacks.empty() ? "has what it needs" : "lacks ",
               fmt::to_string(fmt::join(one.lacks, ", ")));
  }
}

void run(const ColumnsArguments& arguments) {
  const TreeTable trees = open_trees(arguments.inventory, arguments.table, arguments.common);
  const stand::TableDescription description =
      stand::describe_columns(trees.table, study::inventory_options(arguments.reading));
  if (arguments.common.json) return print_json_value(json_of(description));
  print(description);
}

}  // namespace

void add_columns_command(CLI::App& program) {
  const auto arguments = std::make_shared<ColumnsArguments>();
  CLI::App& command = *program.add_subcommand(
      "columns", "Show how each column of a table of trees is read, and what commands lack");
  command
      .add_option("inventory", arguments->inventory, "Table of trees, as for the other commands")
      ->type_name("INVENTORY.csv")
      ->required();
  add_layer_options(command, arguments->table);
  add_reading_options(command, arguments->reading, {"columns", "missing", "fill_down"});
  add_common_options(command, arguments->common);
  add_example(command, "silvafit columns examples/fir-mixed/inventory.csv");
  command.callback([arguments] { run(*arguments); });
}

}  // namespace silvafit::cli
