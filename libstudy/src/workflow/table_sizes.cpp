// SPDX-License-Identifier: MIT
#include "workflow/table_sizes.hpp"

#include <optional>
#include <string_view>
#include <utility>

#include "silvafit/data/checked_columns.hpp"
#include "silvafit/data/expression.hpp"

namespace silvafit::study {
namespace {

void check_units_of(const TableSizes& sizes, const data::Table& table) {
  if (sizes.columns.empty()) return;
  const auto labels = [&table](const char* name) {
    return table.has(name) ? table.labels(name) : data::TextColumn();
  };
  stand::check_units_of_trees(
      labels("plot"), labels("species"), sizes.columns, table.file(), [&table](std::size_t row) {
        return data::place_of(table, row, {});
      });
}

}  // namespace

TableSizes sizes_in(const data::Table& table,
                    const std::vector<stand::ColumnMapping>& mapped,
                    bool is_computed) {
  const auto numbers_of = [&](std::string_view name) -> std::optional<std::vector<double>> {
    const stand::ColumnMapping* const mapping = stand::mapping_to(name, mapped);
    if (mapping == nullptr || is_computed) {
      if (!table.has(name) || !table.is_numeric(name)) return std::nullopt;
      const auto numbers = table.numbers(name);
      return std::vector<double>(numbers.begin(), numbers.end());
    }
    return stand::numbers_from(table, name, mapping->source);
  };
  TableSizes sizes;
  if (!numbers_of("dbh")) return sizes;
  for (const stand::TreeColumn& column : stand::tree_columns()) {
    if (!column.is_measure() || column.is_position()) continue;
    auto numbers = numbers_of(column.name);
    if (!numbers) continue;
    const stand::ColumnMapping* const mapping = stand::mapping_to(column.name, mapped);
    std::string source(column.name);
    if (mapping != nullptr) {
      const bool is_column = data::Expression::variable(mapping->source).text() == mapping->source;
      source = is_column ? mapping->source : "(" + mapping->source + ")";
    }
    sizes.values.push_back(std::move(*numbers));
    sizes.columns.push_back(
        {.name = column.name, .source = std::move(source), .values = sizes.values.back()});
  }
  return sizes;
}

void check_sizes(const data::Table& table,
                 const TableSizes& sizes,
                 bool trust_units,
                 ReadingState& state,
                 std::vector<std::string>& notes) {
  if (!std::exchange(state.is_begun, true) && !trust_units) check_units_of(sizes, table);
  const auto place_of = [&table](std::size_t row) { return data::place_of(table, row, {}); };
  for (const stand::SizeColumn& column : sizes.columns) {
    state.odd_values.add(column.name, column.values, place_of);
  }
  for (std::string& text : state.odd_values.notes()) notes.push_back(std::move(text));
}

void check_units(const data::Table& table) { check_units_of(sizes_in(table, {}, true), table); }

}  // namespace silvafit::study
