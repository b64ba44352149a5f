// SPDX-License-Identifier: MIT
#include "silvafit/data/missing_codes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace silvafit::data {

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

}  // namespace silvafit::data
