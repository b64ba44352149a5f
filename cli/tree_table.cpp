// SPDX-License-Identifier: MIT
#include "tree_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/inventory.hpp"
#include "silvafit/study/table_checks.hpp"

namespace silvafit::cli {
namespace {

using Names = std::vector<std::string>;
using Mappings = std::vector<stand::ColumnMapping>;

bool contains(const Names& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::string joined(const Names& entries) { return fmt::format("{}", fmt::join(entries, ",")); }

/// Adds a column with our name; the table also keeps its own.
void add_column(const stand::ColumnMapping& column, data::Table& table) {
  if (table.is_numeric(column.source)) {
    const auto values = table.numbers(column.source);
    table.set(column.name, std::vector<double>(values.begin(), values.end()));
  } else {
    table.set(column.name, data::TextColumn(table.text(column.source)));
  }
}

/// Reads a file and adds standard columns that it has with another common spelling.
/// \param names   columns that stay text, with our names
/// \param mapped  columns with a given source; they are not added
data::Table read_table(const std::filesystem::path& file,
                       const Names& names,
                       const Mappings& mapped,
                       const std::function<bool(const std::string&)>& is_wanted,
                       const CommonOptions& common) {
  const auto is_mapped = [&mapped](const std::string& name) {
    return std::ranges::find(mapped, name, &stand::ColumnMapping::name) != mapped.end();
  };
  data::CsvReader reader(file);
  const Mappings usual = stand::usual_columns(
      reader.header(),
      [&](const std::string& name) { return is_wanted(name) && !is_mapped(name); },
      file.string());
  // Plot 07 is not plot 7, for any name of the column.
  Names texts = names;
  for (const Mappings* const mappings : {&mapped, &usual}) {
    for (const stand::ColumnMapping& mapping : *mappings) {
      if (contains(names, mapping.name)) texts.push_back(mapping.source);
    }
  }
  data::Table table = data::read_csv_table(reader, {.text_columns = texts});
  for (const stand::ColumnMapping& column : usual) {
    add_column(column, table);
    say(common, "note: " + stand::describe_usual_column(column));
  }
  return table;
}

}  // namespace

CLI::Option* add_columns_option(CLI::App& command, std::vector<std::string>& columns) {
  return command
      .add_option("--columns", columns, "Source of columns, such as dbh=DBH_mm/10,h=Height,x=xk/10")
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
}

std::map<std::string, std::string> column_map(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> map;
  for (stand::ColumnMapping& mapping : stand::parse_column_mappings(joined(entries))) {
    map.emplace(std::move(mapping.name), std::move(mapping.source));
  }
  return map;
}

data::Table read_tree_table(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& columns,
                            const CommonOptions& common) {
  Mappings mapped;
  for (const auto& [name, source] : columns) mapped.push_back({name, source});
  const auto all = [](const std::string&) { return true; };
  return read_table(file, {"plot", "tree", "species"}, mapped, all, common);
}

data::Table read_model_table(const std::filesystem::path& file,
                             const ModelColumns& columns,
                             const CommonOptions& common) {
  const std::string entries = joined(columns.entries);
  const auto is_wanted = [&](const std::string& name) { return contains(columns.wanted, name); };
  data::Table table =
      read_table(file, columns.names, stand::parse_column_mappings(entries), is_wanted, common);
  for (const std::string& note : study::add_columns(entries, table, columns.units)) {
    say(common, "note: " + note);
  }
  return table;
}

}  // namespace silvafit::cli
