// SPDX-License-Identifier: MIT
#include "model/model_groups.hpp"

#include <algorithm>
#include <boost/pending/disjoint_sets.hpp>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <utility>

#include "model/group_labels.hpp"

namespace silvafit::fit {
namespace {

using Keys = std::vector<std::uint64_t>;

/// A number for the group of each row of the table, in the order of the labels of the term's
/// columns, the coarsest first.
Keys keys_of(const std::vector<data::TextColumn>& columns, const std::vector<std::size_t>& rows) {
  Keys result(columns.front().size(), 0);
  for (const data::TextColumn& column : columns) {
    for (const std::size_t row : rows) {
      result[row] = result[row] * column.levels().size() + column.code(row);
    }
  }
  return result;
}

/// The place of each row's group among the groups of a term.
std::vector<std::size_t> places_of(const Keys& keys,
                                   const std::vector<std::size_t>& rows,
                                   std::size_t& count) {
  Keys distinct;
  for (const std::size_t row : rows) distinct.push_back(keys[row]);
  std::ranges::sort(distinct);
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  count = distinct.size();
  std::vector<std::size_t> result(keys.size(), 0);
  for (const std::size_t row : rows) {
    const auto found = std::ranges::lower_bound(distinct, keys[row]);
    result[row] = static_cast<std::size_t>(found - distinct.begin());
  }
  return result;
}

/// Sets of rows that groups of crossed terms connect, numbered by their first group of the first
/// term.
Keys connected(const std::vector<Keys>& keys, const std::vector<std::size_t>& rows) {
  std::vector<std::vector<std::size_t>> places;
  std::vector<std::size_t> begins{0};
  for (const Keys& of_term : keys) {
    std::size_t count = 0;
    places.push_back(places_of(of_term, rows, count));
    begins.push_back(begins.back() + count);
  }
  boost::disjoint_sets_with_storage<> sets(begins.back());
  for (const std::size_t row : rows) {
    for (std::size_t t = 1; t < keys.size(); ++t) {
      sets.union_set(places[0][row], begins[t] + places[t][row]);
    }
  }
  Keys first(begins.back(), std::numeric_limits<std::uint64_t>::max());
  for (const std::size_t row : rows) {
    std::uint64_t& known = first[sets.find_set(places[0][row])];
    known = std::min<std::uint64_t>(known, places[0][row]);
  }
  Keys result(keys.front().size(), 0);
  for (const std::size_t row : rows) result[row] = first[sets.find_set(places[0][row])];
  return result;
}

}  // namespace

CellRows cell_rows(const ModelSpecification& specification,
                   const data::Table& table,
                   const std::vector<bool>& complete) {
  const GroupLabels labels(specification, table);
  const std::size_t terms = specification.random.size();
  CellRows result;
  for (std::size_t row = 0; row < complete.size(); ++row) {
    if (complete[row] && !labels.is_missing(row)) result.rows.push_back(row);
  }
  std::vector<Keys> keys;  // of the clusters, then of each term
  for (const auto& columns : labels.columns()) keys.push_back(keys_of(columns, result.rows));
  ModelGroups& groups = result.groups;
  groups.is_crossed = are_crossed(specification.random);
  if (terms > 0) {
    keys.insert(keys.begin(), groups.is_crossed ? connected(keys, result.rows) : keys.front());
  }
  const auto difference = [&keys](std::size_t a, std::size_t b) {
    return std::ranges::find_if(keys, [a, b](const Keys& of) { return of[a] != of[b]; });
  };
  std::ranges::stable_sort(result.rows, [&](std::size_t a, std::size_t b) {
    const auto part = difference(a, b);
    return part != keys.end() && (*part)[a] < (*part)[b];
  });
  groups.labels.resize(terms);
  groups.of_cells.resize(terms);
  groups.cluster_begin.resize(terms);
  std::vector<std::unordered_map<std::uint64_t, Index>> numbers(terms);
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    const std::size_t row = result.rows[i];
    const auto part = i == 0 ? keys.begin() : difference(result.rows[i - 1], row);
    if (i > 0 && part == keys.end()) continue;
    const bool begins_cluster = part == keys.begin();
    if (begins_cluster) groups.first_cell.push_back(std::ssize(result.cell_begin));
    result.cell_begin.push_back(static_cast<Index>(i));
    for (std::size_t t = 0; t < terms; ++t) {
      const Index count = std::ssize(groups.labels[t]);
      if (begins_cluster) groups.cluster_begin[t].push_back(count);
      const auto [place, is_new] = numbers[t].emplace(keys[t + 1][row], count);
      if (is_new) groups.labels[t].push_back(labels.of(t, row));
      groups.of_cells[t].push_back(place->second);
    }
  }
  for (std::size_t t = 0; t < terms; ++t) {
    groups.cluster_begin[t].push_back(std::ssize(groups.labels[t]));
  }
  groups.first_cell.push_back(std::ssize(result.cell_begin));
  result.cell_begin.push_back(std::ssize(result.rows));
  return result;
}

ModelGroups ModelGroups::one_cluster(std::vector<std::vector<std::string>> labels,
                                     std::vector<std::vector<Index>> of_cells) {
  ModelGroups result{.is_crossed = true, .first_cell = {0, std::ssize(of_cells.front())}};
  for (const std::vector<std::string>& of_term : labels) {
    result.cluster_begin.push_back({0, std::ssize(of_term)});
  }
  result.labels = std::move(labels);
  result.of_cells = std::move(of_cells);
  return result;
}

ModelGroups ModelGroups::part(const std::vector<Index>& cells,
                              std::vector<Index> cluster_cells) const {
  ModelGroups result{.is_crossed = is_crossed, .first_cell = std::move(cluster_cells)};
  for (std::size_t t = 0; t < labels.size(); ++t) {
    std::vector<Index> numbers(labels[t].size(), -1);
    std::vector<std::string>& kept = result.labels.emplace_back();
    std::vector<Index>& of = result.of_cells.emplace_back();
    std::vector<Index>& begin = result.cluster_begin.emplace_back();
    std::size_t cluster = 0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      for (; cluster < result.first_cell.size() &&
             static_cast<Index>(k) == result.first_cell[cluster];
           ++cluster) {
        begin.push_back(std::ssize(kept));
      }
      const auto group = static_cast<std::size_t>(group_of(t, cells[k]));
      if (numbers[group] < 0) {
        numbers[group] = std::ssize(kept);
        kept.push_back(labels[t][group]);
      }
      of.push_back(numbers[group]);
    }
    begin.push_back(std::ssize(kept));
  }
  return result;
}

std::string ModelGroups::cell_label(Index cell) const {
  std::vector<std::string_view> all(labels.size());
  for (std::size_t t = labels.size(); t-- > 0;) {
    all[t] = labels[t][static_cast<std::size_t>(group_of(t, cell))];
    if (labels[t].size() == of_cells[t].size()) return std::string(all[t]);
  }
  return all.empty() ? std::string() : nested_label(all);
}

}  // namespace silvafit::fit
