// SPDX-License-Identifier: MIT
#include "prediction/known_levels.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/data/csv.hpp"

namespace silvafit::fit {
namespace {

/// Equal text, or the same number: "01" is 1.
bool is_known(const std::string& label, const std::vector<std::string>& known) {
  if (std::ranges::find(known, label) != known.end()) return true;
  double number = 0.0;
  if (!data::parse_number(label, number)) return false;
  return std::ranges::any_of(known, [number](const std::string& one) {
    double value = 0.0;
    return data::parse_number(one, value) && value == number;
  });
}

/// The labels of a column, unknown ones missing; none if all are known.
std::optional<data::TextColumn> known_labels(const ColumnLevels& levels, const data::Table& table) {
  const data::TextColumn labels = table.labels(levels.column);
  std::vector<bool> is_wanted;
  for (const std::string& label : labels.levels()) {
    is_wanted.push_back(is_known(label, levels.labels));
  }
  if (std::ranges::find(is_wanted, false) == is_wanted.end()) return std::nullopt;
  data::TextColumn result;
  result.reserve(labels.size());
  for (std::size_t row = 0; row < labels.size(); ++row) {
    if (labels.is_missing(row) || !is_wanted[labels.code(row)]) {
      result.append_missing();
    } else {
      result.append(labels[row]);
    }
  }
  return result;
}

/// Numbers remain numbers, because the formula may read them, too.
std::vector<double> where_known(std::vector<double> numbers, const data::TextColumn& labels) {
  for (std::size_t row = 0; row < numbers.size(); ++row) {
    if (labels.is_missing(row)) numbers[row] = data::kMissing;
  }
  return numbers;
}

}  // namespace

std::optional<data::Table> without_unknown_levels(const FittedModel& fit,
                                                  const data::Table& table) {
  std::optional<data::Table> result;
  for (const ColumnLevels& levels : fit.levels) {
    const auto& factors = fit.specification.factors;
    if (std::ranges::find(factors, levels.column) == factors.end()) continue;
    std::optional<data::TextColumn> known = known_labels(levels, table);
    if (!known) continue;
    if (!result) result = table;
    if (table.is_numeric(levels.column)) {
      const auto numbers = table.numbers(levels.column);
      result->set(levels.column, where_known({numbers.begin(), numbers.end()}, *known));
    } else {
      result->set(levels.column, *std::move(known));
    }
  }
  return result;
}

}  // namespace silvafit::fit
