// SPDX-License-Identifier: MIT
#include "silvafit/data/missing_codes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "silvafit/base/median.hpp"

namespace silvafit::data {
namespace {

/// The value at an end of a column that is far from all others, and repeated unless nobody measures
/// it by chance.
/// \param values  ascending
template <class Condition>
std::optional<double> isolated_end(const std::vector<double>& values, Condition is_code) {
  constexpr std::ptrdiff_t kRepeated = 3;
  constexpr double kNeverMeasured = 9999.0;
  constexpr std::size_t kFewestOthers = 10;
  constexpr double kIsolated = 20.0;  // typical distances of neighbors
  std::vector<double> distinct = values;
  distinct.erase(std::ranges::unique(distinct).begin(), distinct.end());
  if (distinct.size() < kFewestOthers) return std::nullopt;
  std::vector<double> gaps(distinct.size());
  std::adjacent_difference(distinct.begin(), distinct.end(), gaps.begin());
  gaps.erase(gaps.begin());
  const double typical = median(gaps);
  for (const auto& [end, gap] :
       {std::pair(distinct.front(), gaps.front()), std::pair(distinct.back(), gaps.back())}) {
    if (!is_code(end) || gap < kIsolated * typical) continue;
    const auto count = std::ranges::count(values, end);
    if (count >= (std::abs(end) >= kNeverMeasured ? 1 : kRepeated)) return end;
  }
  return std::nullopt;
}

}  // namespace

bool is_all_nines(double value) {
  if (!(std::abs(value) >= 9.0)) return false;
  std::string text = shortest(std::abs(value));
  std::erase(text, '.');
  return text.find_first_not_of('9') == std::string::npos;
}

bool is_missing_code(double value) { return value == -9999.0 || value == -99999.0; }

bool is_likely_missing_code(double value) {
  return value == -9.0 || value == -99.0 || value == -999.0;
}

std::optional<double> possible_code(std::span<const double> all, bool zero) {
  std::vector<double> values;
  std::ranges::copy_if(all, std::back_inserter(values), [](double v) { return !std::isnan(v); });
  if (values.empty()) return std::nullopt;
  std::ranges::sort(values);
  const double least = values.front();
  const auto next = std::ranges::upper_bound(values, least);
  const bool is_only_negative = next == values.end() || *next >= 0.0;
  if (is_only_negative && (is_missing_code(least) || is_likely_missing_code(least))) return least;
  // 9 and 9.9 may be sizes.
  return isolated_end(values, [zero](double value) {
    return value == 0.0 ? zero : std::abs(value) >= 99.0 && is_all_nines(value);
  });
}

void refuse_possible_code(std::span<const double> values, Place place) {
  const std::optional<double> code = possible_code(values);
  if (!code) return;
  const std::string text = shortest(*code);
  throw InputError(fmt::format("the value {} in {} rows may be a code of missing values: if it is, "
                               "use `missing={}`; if it is a measurement, use `trust_units=true`",
                               text,
                               std::ranges::count(values, *code),
                               text),
                   std::move(place));
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
