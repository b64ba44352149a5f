// SPDX-License-Identifier: MIT
#include <algorithm>
#include <span>

#include "study/study_work.hpp"

namespace silvafit::study {
namespace {

/// Number of trees that determine the random effects of a plot about as well as all of its trees.
constexpr std::size_t kEnough = 40;

std::vector<std::vector<std::size_t>> rows_by_group(const data::Table& table,
                                                    const std::string& group) {
  const data::TextColumn labels = table.labels(group);
  std::vector<std::vector<std::size_t>> groups(labels.levels().size());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!labels.is_missing(row)) groups[labels.code(row)].push_back(row);
  }
  return groups;
}

/// Some rows of a group, evenly spaced from its thinnest to its thickest tree.
std::vector<std::size_t> spread(const data::Table& table,
                                std::vector<std::size_t> rows,
                                std::size_t count) {
  if (rows.size() <= count) return rows;
  if (table.has("dbh") && table.is_numeric("dbh")) {
    const std::span<const double> dbh = table.numbers("dbh");
    std::ranges::stable_sort(rows, {}, [dbh](std::size_t row) { return dbh[row]; });
  }
  std::vector<std::size_t> result;
  for (std::size_t k = 0; k < count; ++k) {
    // The middle of each of the parts.
    result.push_back(rows[(2 * k + 1) * rows.size() / (2 * count)]);
  }
  return result;
}

}  // namespace

std::vector<std::size_t> representative_rows(const data::Table& table,
                                             const std::string& group,
                                             std::size_t wanted) {
  const auto groups = rows_by_group(table, group);
  const std::size_t share = std::max(kEnough, wanted / std::max<std::size_t>(1, groups.size()));
  std::size_t available = 0;
  for (const auto& rows : groups) available += std::min(rows.size(), share);
  const std::size_t step = (available + wanted - 1) / wanted;
  std::vector<std::size_t> result;
  for (std::size_t k = 0; k < groups.size(); k += step) {
    const auto taken = spread(table, groups[k], share);
    result.insert(result.end(), taken.begin(), taken.end());
  }
  std::ranges::sort(result);
  return result;
}

}  // namespace silvafit::study
