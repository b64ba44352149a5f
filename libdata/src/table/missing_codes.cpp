// SPDX-License-Identifier: MIT
#include "silvafit/data/missing_codes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace silvafit::data {

bool is_missing_code(double value) { return value == -9999.0 || value == -99999.0; }

bool is_likely_missing_code(double value) {
  return value == -9.0 || value == -99.0 || value == -999.0;
}

void take_missing_codes(Table& table, MissingCodes& found) {
  const std::vector<std::string> names = table.names();
  for (const std::string& name : names) {
    if (!table.is_numeric(name)) continue;
    const auto numbers = table.numbers(name);
    if (std::ranges::none_of(numbers, is_missing_code)) continue;
    std::vector<double> values(numbers.begin(), numbers.end());
    for (double& value : values) {
      if (!is_missing_code(value)) continue;
      found.add(name, shortest(value));
      value = kMissing;
    }
    table.set(name, std::move(values));
  }
}

void MissingCodes::add(std::string_view column, std::string_view code, std::size_t count) {
  auto found = std::ranges::find(columns_, column, &Column::name);
  if (found == columns_.end()) {
    columns_.push_back({.name = std::string(column)});
    found = columns_.end() - 1;
  }
  found->count += count;
  if (std::ranges::find(found->codes, code) == found->codes.end()) {
    found->codes.emplace_back(code);
  }
}

std::string MissingCodes::text() const {
  std::vector<std::string> parts;
  parts.reserve(columns_.size());
  for (const Column& column : columns_) {
    parts.push_back(
        fmt::format("{} {} ({})", column.name, column.count, fmt::join(column.codes, ", ")));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string MissingCodes::note() const {
  return empty() ? "" : "codes read as missing values: " + text();
}

}  // namespace silvafit::data
