// SPDX-License-Identifier: MIT
// Parser of the text of --columns.
#include <fmt/format.h>

#include <algorithm>

#include "silvafit/data/csv.hpp"
#include "silvafit/stand/inventory.hpp"

namespace silvafit::stand {
namespace {

constexpr char kColumnsOption[] = "`columns`";

/// Splits at commas that stand outside parentheses, double quotes and backquotes.
std::vector<std::string_view> split_at_commas(std::string_view text) {
  std::vector<std::string_view> parts;
  int depth = 0;
  char quote = '\0';  // the one that is open
  std::size_t start = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_quote = text[i] == '"' || text[i] == '`';
    if (is_quote && quote == '\0') {
      quote = text[i];
    } else if (text[i] == quote) {
      quote = '\0';
    }
    if (quote != '\0') continue;
    if (text[i] == '(') ++depth;
    if (text[i] == ')') --depth;
    if (text[i] != ',' || depth > 0) continue;
    parts.push_back(text.substr(start, i - start));
    start = i + 1;
  }
  parts.push_back(text.substr(start));
  return parts;
}

ColumnMapping mapping_of(std::string_view part) {
  const std::size_t sign = part.find('=');
  if (sign != std::string_view::npos) {
    const std::string_view name = data::trimmed(part.substr(0, sign));
    const std::string_view source = data::trimmed(part.substr(sign + 1));
    if (!name.empty() && !source.empty() && !source.starts_with('=')) {
      return {.name = std::string(name), .source = std::string(source)};
    }
  }
  throw UsageError(fmt::format("'{}' is not NAME=COLUMN, such as dbh=DBH_cm or x=xk/10", part),
                   {.column = kColumnsOption});
}

}  // namespace

std::vector<ColumnMapping> parse_column_mappings(std::string_view text) {
  std::vector<ColumnMapping> mappings;
  if (data::trimmed(text).empty()) return mappings;
  for (const std::string_view part : split_at_commas(text)) {
    ColumnMapping mapping = mapping_of(part);
    const bool known = std::ranges::any_of(
        mappings, [&mapping](const ColumnMapping& other) { return other.name == mapping.name; });
    if (known) {
      throw UsageError(fmt::format("'{}' is given twice", mapping.name),
                       {.column = kColumnsOption});
    }
    mappings.push_back(std::move(mapping));
  }
  return mappings;
}

}  // namespace silvafit::stand
