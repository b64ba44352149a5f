// SPDX-License-Identifier: MIT
#include "text_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "standard_output.hpp"

namespace silvafit::cli {

std::string rounded(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

std::string with_error(double value, double error, int digits) {
  if (!std::isfinite(error)) return rounded(value, digits);
  return fmt::format("{} +- {}", rounded(value, digits), rounded(error, digits));
}

std::string name_or(const std::string& name, const char* otherwise) {
  return name.empty() ? otherwise : name;
}

TextTable::TextTable(std::vector<ShownColumn> columns) : columns_(std::move(columns)) {
  std::vector<std::string>& header = rows_.emplace_back();
  for (const ShownColumn& column : columns_) header.push_back(column.title);
}

void TextTable::add(const data::Table& table) {
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::vector<std::string>& cells = rows_.emplace_back();
    for (const ShownColumn& shown : columns_) {
      if (!table.is_numeric(shown.column)) {
        cells.push_back(name_or(std::string(table.text(shown.column)[row]), shown.otherwise));
      } else {
        const double error = shown.error.empty() ? NAN : table.numbers(shown.error)[row];
        cells.push_back(with_error(table.numbers(shown.column)[row], error, shown.digits));
      }
    }
  }
}

void TextTable::print() const {
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  for (const auto& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows_) {
    std::string line = fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i) line += fmt::format("  {:>{}}", row[i], widths[i]);
    print_text("{}\n", line);
  }
  print_text("\n");
}

}  // namespace silvafit::cli
