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
