// SPDX-License-Identifier: MIT
#include "trees/distinguishing_columns.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

namespace silvafit::stand {
namespace {

/// A part of a label.
struct PartPlace {
  std::size_t label = 0;
  std::size_t part = 0;
};

bool can_be_read_again(const data::TableSource& source) {
  const auto* const file = std::get_if<std::filesystem::path>(&source);
  std::error_code ignored;
  return file == nullptr || std::filesystem::is_regular_file(*file, ignored);
}

/// Adds a row's value; false if the part has another one, or if there is none.
bool add(std::string_view value, std::string& of_part) {
  if (of_part.empty()) of_part = value;
  return !value.empty() && of_part == value;
}

bool are_distinct(const std::vector<std::vector<std::string>>& values) {
  return std::ranges::all_of(values, [](const std::vector<std::string>& parts) {
    return std::set<std::string_view>(parts.begin(), parts.end()).size() == parts.size();
  });
}

}  // namespace

std::vector<DistinguishingColumn> distinguishing_columns(const data::TableSource& source,
                                                         const std::vector<std::string>& missing,
                                                         const std::vector<std::size_t>& fields,
                                                         const std::vector<LabelParts>& labels) {
  if (labels.empty() || !can_be_read_again(source)) return {};
  std::unordered_map<std::size_t, PartPlace> place_of_row;
  std::vector<std::vector<std::string>> none;
  for (std::size_t label = 0; label < labels.size(); ++label) {
    none.emplace_back(labels[label].rows.size());
    for (std::size_t part = 0; part < labels[label].rows.size(); ++part) {
      for (const std::size_t row : labels[label].rows[part]) place_of_row[row] = {label, part};
    }
  }
  std::vector<DistinguishingColumn> columns;
  for (const std::size_t field : fields) columns.push_back({.field = field, .values = none});
  data::CsvReader csv(source, missing);
  std::vector<std::string_view> values;
  for (std::size_t row = 0; !columns.empty() && csv.next(values); ++row) {
    const auto place = place_of_row.find(row);
    if (place == place_of_row.end()) continue;
    const auto [label, part] = place->second;
    std::erase_if(columns, [&, label, part](DistinguishingColumn& column) {
      return !add(data::trimmed(values[column.field]), column.values[label][part]);
    });
  }
  std::erase_if(columns, [](const DistinguishingColumn& of) { return !are_distinct(of.values); });
  for (DistinguishingColumn& column : columns) {
    std::set<std::string_view> distinct;
    for (const auto& parts : column.values) distinct.insert(parts.begin(), parts.end());
    column.distinct = distinct.size();
  }
  std::ranges::stable_sort(columns, {}, &DistinguishingColumn::distinct);
  return columns;
}

}  // namespace silvafit::stand
