// SPDX-License-Identifier: MIT
#include "model/crossed_groups.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "model/group_labels.hpp"

namespace silvafit::fit {
namespace {

using Eigen::Index;

/// Sets of elements that are joined step by step.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
  }
  std::size_t find(std::size_t of) {
    while (parents_[of] != of) of = parents_[of] = parents_[parents_[of]];
    return of;
  }
  /// The smallest element represents a set.
  void join(std::size_t a, std::size_t b) {
    const std::size_t first = find(a);
    const std::size_t second = find(b);
    parents_[std::max(first, second)] = std::min(first, second);
  }

 private:
  std::vector<std::size_t> parents_;
};

/// The groups of all terms of the rows, numbered by first appearance.
struct RowGroups {
  std::vector<std::size_t> rows{};
  std::vector<std::vector<std::string>> labels{};   ///< of each term
  std::vector<std::vector<std::size_t>> of_rows{};  ///< by row of the table, of each term

  RowGroups(const ModelSpecification& specification,
            const data::Table& table,
            const std::vector<bool>& complete) {
    const GroupLabels all(specification, table);
    const std::size_t terms = specification.random.size();
    std::vector<LabelNumbers> numbers(terms);
    labels.resize(terms);
    of_rows.assign(terms, std::vector<std::size_t>(table.rows(), 0));
    std::vector<std::string> of_row(terms);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      for (std::size_t t = 0; t < terms && complete[row]; ++t) of_row[t] = all.of(t, row);
      const auto is_missing = [](const std::string& label) { return label.empty(); };
      if (!complete[row] || std::ranges::any_of(of_row, is_missing)) continue;
      rows.push_back(row);
      for (std::size_t t = 0; t < terms; ++t) {
        const auto [place, is_new] =
            numbers[t].emplace(of_row[t], static_cast<Index>(labels[t].size()));
        if (is_new) labels[t].push_back(of_row[t]);
        of_rows[t][row] = static_cast<std::size_t>(place->second);
      }
    }
  }

  /// By row of the table: a number of the cluster, ascending with the first rows of clusters.
  std::vector<std::size_t> clusters() const {
    std::vector<std::size_t> begins{0};
    for (const auto& of_term : labels) begins.push_back(begins.back() + of_term.size());
    DisjointSets sets(begins.back());
    for (const std::size_t row : rows) {
      for (std::size_t t = 1; t < labels.size(); ++t) {
        sets.join(of_rows[0][row], begins[t] + of_rows[t][row]);
      }
    }
    std::vector<std::size_t> result(of_rows[0].size(), 0);
    for (const std::size_t row : rows) result[row] = sets.find(of_rows[0][row]);
    return result;
  }
};

}  // namespace

CellRows cell_rows(const ModelSpecification& specification,
                   const data::Table& table,
                   const std::vector<bool>& complete) {
  const RowGroups all(specification, table, complete);
  const std::vector<std::size_t> clusters = all.clusters();
  const std::size_t terms = all.labels.size();
  CellRows result{.rows = all.rows};
  const auto key_of = [&](std::size_t row, std::size_t part) {
    return part == 0 ? clusters[row] : all.of_rows[part - 1][row];
  };
  const auto difference = [&](std::size_t a, std::size_t b) {
    std::size_t part = 0;
    while (part <= terms && key_of(a, part) == key_of(b, part)) ++part;
    return part;
  };
  std::ranges::stable_sort(result.rows, [&](std::size_t a, std::size_t b) {
    const std::size_t part = difference(a, b);
    return part <= terms && key_of(a, part) < key_of(b, part);
  });
  CrossedGroups whole{.labels = all.labels, .of_cells{terms, std::vector<Index>()}};
  for (std::size_t i = 0; i < result.rows.size(); ++i) {
    const std::size_t row = result.rows[i];
    const std::size_t part = i == 0 ? 0 : difference(result.rows[i - 1], row);
    if (part > terms) continue;
    if (part == 0) result.cluster_begin.push_back(std::ssize(result.cell_begin));
    result.cell_begin.push_back(static_cast<Index>(i));
    for (std::size_t t = 0; t < terms; ++t) {
      whole.of_cells[t].push_back(static_cast<Index>(all.of_rows[t][row]));
    }
  }
  const Index count = std::ssize(result.cell_begin);
  result.cell_begin.push_back(std::ssize(result.rows));
  result.cluster_begin.push_back(count);
  std::vector<Index> cells(static_cast<std::size_t>(count));
  std::iota(cells.begin(), cells.end(), Index{0});
  result.groups = whole.part(cells, result.cluster_begin);
  return result;
}

CrossedGroups CrossedGroups::part(const std::vector<Index>& cells,
                                  const std::vector<Index>& cluster_cells) const {
  CrossedGroups result;
  for (std::size_t t = 0; t < labels.size(); ++t) {
    std::vector<Index> numbers(labels[t].size(), -1);
    std::vector<std::string>& kept = result.labels.emplace_back();
    std::vector<Index>& of = result.of_cells.emplace_back();
    std::vector<Index>& begin = result.cluster_begin.emplace_back();
    std::size_t cluster = 0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      for (; cluster < cluster_cells.size() && static_cast<Index>(k) == cluster_cells[cluster];
           ++cluster) {
        begin.push_back(std::ssize(kept));
      }
      const auto group = static_cast<std::size_t>(of_cells[t][static_cast<std::size_t>(cells[k])]);
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

std::string CrossedGroups::cell_label(Index cell) const {
  const auto at = static_cast<std::size_t>(cell);
  std::vector<std::string_view> all;
  for (std::size_t t = 0; t < labels.size(); ++t) {
    const std::string& label = labels[t][static_cast<std::size_t>(of_cells[t][at])];
    if (labels[t].size() == of_cells[t].size()) return label;
    all.push_back(label);
  }
  return nested_label(all);
}

}  // namespace silvafit::fit
