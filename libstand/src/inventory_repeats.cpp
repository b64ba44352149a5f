// SPDX-License-Identifier: MIT
#include "inventory_repeats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "inventory_columns.hpp"

namespace silvafit::stand {
namespace {

/// What tells two trees of one id apart: the position or, without one, all measures.
std::vector<double> identity_of(const Inventory& inventory, std::size_t row) {
  const bool is_placed =
      inventory.has_coordinates() && !std::isnan(inventory.x[row]) && !std::isnan(inventory.y[row]);
  if (is_placed) return {inventory.x[row], inventory.y[row]};
  std::vector<double> measures;
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    const std::vector<double>& values = values_of(inventory, i);
    // Missing values are alike, and NaN has no place in an order.
    const bool is_missing = values.empty() || std::isnan(values[row]);
    measures.push_back(is_missing ? -std::numeric_limits<double>::infinity() : values[row]);
  }
  return measures;
}

using PlotAndTree = std::pair<std::uint32_t, std::string>;

/// Hands out `64#2`, `64#3`, ... as far as the plot has not used them.
class IdSupply {
 public:
  explicit IdSupply(const Inventory& inventory) {
    for (std::size_t row = 0; row < inventory.size(); ++row) {
      const std::string_view id = inventory.tree[row];
      if (id.find('#') != std::string_view::npos) taken_.emplace(inventory.plot.code(row), id);
    }
  }

  std::string next(std::uint32_t plot, const std::string& id) {
    std::size_t& number = last_number_.try_emplace({plot, id}, 1).first->second;
    for (;;) {
      std::string candidate = fmt::format("{}#{}", id, ++number);
      if (taken_.emplace(plot, candidate).second) return candidate;
    }
  }

 private:
  std::set<PlotAndTree> taken_{};
  std::map<PlotAndTree, std::size_t> last_number_{};
};

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
  std::map<std::vector<double>, std::size_t> first_with_identity;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_first = i == 0 || id(order[i]) != id(order[i - 1]);
    const bool is_last = i + 1 == order.size() || id(order[i]) != id(order[i + 1]);
    if (is_first) first_with_identity.clear();
    if (is_first && is_last) continue;
    const auto [same, is_new] =
        first_with_identity.try_emplace(identity_of(inventory, order[i]), order[i]);
    if (is_first) continue;
    repeated.push_back({.row = order[i], .first_row = same->second, .is_same_tree = !is_new});
  }
  if (repeated.empty()) return repeated;
  std::ranges::sort(repeated, {}, &RepeatedTree::row);

  IdSupply ids(inventory);
  for (RepeatedTree& tree : repeated) {
    if (tree.is_same_tree) continue;
    tree.new_id = ids.next(inventory.plot.code(tree.row), std::string(inventory.tree[tree.row]));
  }
  return repeated;
}

}  // namespace silvafit::stand
