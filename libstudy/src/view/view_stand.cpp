// SPDX-License-Identifier: MIT
#include "view/view_stand.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

namespace silvafit::study {
namespace {

constexpr std::size_t kMostColumns = 30;
constexpr std::size_t kMostTexts = 40;

/// Names of columns that have colors of their own, or no use as colors.
std::set<std::string> shown_names(const std::map<std::string, std::string>& used) {
  std::set<std::string> names{"tree", "species", "x", "y", "dbh", "W", "M", "U", "C"};
  for (const char* size : {"h", "hcb", "cw"}) {
    for (const char* suffix : {"", "_ols", "_population", "_conditional"}) {
      names.insert(std::string(size) + suffix);
    }
  }
  for (const auto& [ours, theirs] : used) {
    if (names.contains(ours)) names.insert(theirs);
  }
  return names;
}

bool has_two_values(const std::vector<double>& values) {
  const auto first = std::ranges::find_if(values, [](double v) { return std::isfinite(v); });
  return std::any_of(
      first, values.end(), [&](double v) { return std::isfinite(v) && v != *first; });
}

/// Texts as indices, by falling number of trees.
ViewColumn text_column(const std::string& name,
                       const data::TextColumn& text,
                       std::span<const std::size_t> rows) {
  std::vector<std::size_t> counts(text.levels().size(), 0);
  for (const std::size_t row : rows) {
    if (!text.is_missing(row)) ++counts[text.code(row)];
  }
  std::vector<std::size_t> order(counts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t code) { return counts[code] == 0; });
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return counts[a] > counts[b]; });
  ViewColumn column{.name = name};
  std::vector<double> number_of(counts.size(), data::kMissing);
  for (const std::size_t code : order) {
    number_of[code] = static_cast<double>(column.texts.size());
    column.texts.push_back(text.levels()[code]);
  }
  for (const std::size_t row : rows) {
    column.values.push_back(text.is_missing(row) ? data::kMissing : number_of[text.code(row)]);
  }
  return column;
}

ViewColumn number_column(const std::string& name,
                         std::span<const double> numbers,
                         std::span<const std::size_t> rows) {
  ViewColumn column{.name = name};
  for (const std::size_t row : rows) column.values.push_back(numbers[row]);
  return column;
}

}  // namespace

std::vector<ViewColumn> color_columns(const data::Table& table,
                                      const std::map<std::string, std::string>& used,
                                      std::span<const std::size_t> rows) {
  const std::set<std::string> shown = shown_names(used);
  std::vector<ViewColumn> columns;
  for (const std::string& name : table.names()) {
    if (columns.size() == kMostColumns) break;
    if (shown.contains(name)) continue;
    ViewColumn column = table.is_numeric(name) ? number_column(name, table.numbers(name), rows)
                                               : text_column(name, table.text(name), rows);
    if (column.texts.size() <= kMostTexts && has_two_values(column.values)) {
      columns.push_back(std::move(column));
    }
  }
  return columns;
}

}  // namespace silvafit::study
