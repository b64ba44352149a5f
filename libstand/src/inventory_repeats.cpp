// SPDX-License-Identifier: MIT
#include "inventory_repeats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "inventory_columns.hpp"

namespace silvafit::stand {
namespace {

bool is_equal_or_both_missing(double left, double right) {
  return left == right || (std::isnan(left) && std::isnan(right));
}

bool has_same_measures(const Inventory& inventory, std::size_t left, std::size_t right) {
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const std::vector<double>& values = values_of(inventory, i);
    if (!values.empty() && !is_equal_or_both_missing(values[left], values[right])) return false;
  }
  return true;
}

bool is_same_tree(const Inventory& inventory, std::size_t left, std::size_t right) {
  const auto is_placed = [&inventory](std::size_t row) {
    return inventory.has_coordinates() && !std::isnan(inventory.x[row]) &&
           !std::isnan(inventory.y[row]);
  };
  if (!is_placed(left) || !is_placed(right)) return has_same_measures(inventory, left, right);
  return inventory.x[left] == inventory.x[right] && inventory.y[left] == inventory.y[right];
}

using PlotAndTree = std::pair<std::uint32_t, std::string>;

/// The first of `64#2`, `64#3`, ... that the plot has not.
std::string free_id(const std::string& id, std::uint32_t plot, std::set<PlotAndTree>& taken) {
  for (std::size_t number = 2;; ++number) {
    std::string candidate = fmt::format("{}#{}", id, number);
    if (taken.emplace(plot, candidate).second) return candidate;
  }
}

}  // namespace

std::vector<RepeatedTree> repeated_trees(const Inventory& inventory) {
  // As many ids as trees: none can repeat, and nothing needs sorting.
  if (inventory.tree.levels().size() == inventory.size()) return {};
  std::vector<std::size_t> order(inventory.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto id = [&inventory](std::size_t row) {
    return std::pair(inventory.plot.code(row), inventory.tree.code(row));
  };
  std::ranges::stable_sort(order, {}, id);

  std::vector<RepeatedTree> repeated;
  std::size_t first = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (id(order[i]) != id(order[first])) {
      first = i;
      continue;
    }
    RepeatedTree tree{.row = order[i], .first_row = order[first]};
    for (std::size_t earlier = first; earlier < i && !tree.is_same_tree; ++earlier) {
      tree.is_same_tree = is_same_tree(inventory, order[earlier], order[i]);
      if (tree.is_same_tree) tree.first_row = order[earlier];
    }
    repeated.push_back(std::move(tree));
  }
  std::ranges::sort(repeated, {}, &RepeatedTree::row);

  std::set<PlotAndTree> taken;
  for (std::size_t row = 0; row < inventory.size() && !repeated.empty(); ++row) {
    const std::string_view name = inventory.tree[row];
    if (name.find('#') != std::string_view::npos) taken.emplace(inventory.plot.code(row), name);
  }
  for (RepeatedTree& tree : repeated) {
    if (tree.is_same_tree) continue;
    tree.new_id =
        free_id(std::string(inventory.tree[tree.row]), inventory.plot.code(tree.row), taken);
  }
  return repeated;
}

}  // namespace silvafit::stand
