// SPDX-License-Identifier: MIT
#include "tree_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <utility>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::cli {
namespace {

/// Columns that name trees; they stay text.
constexpr std::array kLabels{"plot", "tree", "species"};

/// The columns that name trees, in the words of the file.
std::vector<std::string> text_columns(const std::map<std::string, std::string>& columns,
                                      const std::vector<stand::ColumnMapping>& usual = {}) {
  std::vector<std::string> names(kLabels.begin(), kLabels.end());
  for (const char* label : kLabels) {
    const auto mapped = columns.find(label);
    if (mapped != columns.end()) names.push_back(mapped->second);
    const auto found = std::ranges::find(usual, label, &stand::ColumnMapping::name);
    if (found != usual.end()) names.push_back(found->source);
  }
  return names;
}

/// Adds a column under our name; the table keeps its own besides.
void add_column(const stand::ColumnMapping& column, data::Table& table) {
  if (table.is_numeric(column.source)) {
    const auto values = table.numbers(column.source);
    table.set(column.name, std::vector<double>(values.begin(), values.end()));
  } else {
    table.set(column.name, data::TextColumn(table.text(column.source)));
  }
}

}  // namespace

CLI::Option* add_columns_option(CLI::App& command, std::vector<std::string>& columns) {
  return command
      .add_option(
          "--columns", columns, "Where columns come from, such as dbh=DBH_mm/10,h=Height,x=xk/10")
      ->type_name("NAME=COLUMN,...")
      ->allow_extra_args(false);
}

std::map<std::string, std::string> column_map(const std::vector<std::string>& entries) {
  std::map<std::string, std::string> map;
  for (stand::ColumnMapping& mapping :
       stand::parse_column_mappings(fmt::format("{}", fmt::join(entries, ",")))) {
    map.emplace(std::move(mapping.name), std::move(mapping.source));
  }
  return map;
}

data::Table read_tree_table(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& columns,
                            const CommonOptions& common) {
  std::vector<std::string> mapped;
  for (const auto& [name, source] : columns) mapped.push_back(name);
  data::Table table = data::read_csv_table(file, {.text_columns = text_columns(columns)});
  const std::vector<stand::ColumnMapping> usual =
      stand::usual_columns(table.names(), mapped, file.string());
  const std::vector<std::string> texts = text_columns(columns, usual);
  const auto is_numeric = [&table](const std::string& name) {
    return table.has(name) && table.is_numeric(name);
  };
  // Plot 07 is not plot 7: its spelling is in the file only.
  if (std::ranges::any_of(texts, is_numeric)) {
    table = data::read_csv_table(file, {.text_columns = texts});
  }
  for (const stand::ColumnMapping& column : usual) {
    add_column(column, table);
    say(common, "note: " + stand::describe_usual_column(column));
  }
  return table;
}

}  // namespace silvafit::cli
