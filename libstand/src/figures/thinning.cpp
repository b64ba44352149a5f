// SPDX-License-Identifier: MIT
#include "silvafit/stand/thinning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "silvafit/base/error.hpp"
#include "silvafit/data/csv.hpp"
#include "units/density_indices.hpp"

namespace silvafit::stand {
namespace {

/// The trees of an area in the order in which they are removed, while the target remains.
void remove_to_target(const Inventory& inventory,
                      const SampledArea& area,
                      const ThinningRule& rule,
                      std::vector<char>& is_removed) {
  const bool is_below = rule.kind == ThinningRule::Kind::kBelow;
  std::vector<std::size_t> order = area.trees;
  std::ranges::stable_sort(order, [&](std::size_t left, std::size_t right) {
    const double a = inventory.dbh_cm[left];
    const double b = inventory.dbh_cm[right];
    return is_below ? a < b : a > b;
  });
  const double hectares = area.area_m2 / kSquareMetersPerHectare;
  const auto per_ha = [&](std::size_t tree) {
    return inventory.trees_represented(tree) * basal_area_m2(inventory.dbh_cm[tree]) / hectares;
  };
  double remaining = 0.0;
  for (const std::size_t tree : order) remaining += per_ha(tree);
  const double rounding = 1e-12 * remaining;
  for (const std::size_t tree : order) {
    remaining -= per_ha(tree);
    if (!(remaining + rounding >= rule.basal_area_m2_per_ha)) return;
    is_removed[tree] = 1;
  }
}

std::vector<char> removed_trees(const Inventory& inventory,
                                const StandReport& report,
                                const ThinningRule& rule) {
  std::vector<char> is_removed(inventory.size(), 0);
  if (rule.kind != ThinningRule::Kind::kMarked) {
    for (const AreaReport& area : report.areas) {
      remove_to_target(inventory, area.area, rule, is_removed);
    }
    return is_removed;
  }
  if (!inventory.other.has(rule.column) || !inventory.other.is_numeric(rule.column)) {
    throw InputError(
        fmt::format("'{}' is not a column of numbers, in which marked trees have another than 0",
                    rule.column),
        {.file = inventory.file, .column = "`thinning`"});
  }
  const auto marks = inventory.other.numbers(rule.column);
  for (std::size_t tree = 0; tree < marks.size(); ++tree) {
    is_removed[tree] = !std::isnan(marks[tree]) && marks[tree] != 0.0 ? 1 : 0;
  }
  return is_removed;
}

}  // namespace

ThinningRule parse_thinning(std::string_view text) {
  const std::size_t sign = text.find('=');
  const std::string_view kind = text.substr(0, sign);
  const std::string_view value = sign == std::string_view::npos ? "" : text.substr(sign + 1);
  if (kind == "marked" && !value.empty()) {
    return {.kind = ThinningRule::Kind::kMarked, .column = std::string(value)};
  }
  ThinningRule rule{.kind =
                        kind == "above" ? ThinningRule::Kind::kAbove : ThinningRule::Kind::kBelow};
  const bool is_target = (kind == "below" || kind == "above") &&
                         data::parse_number(value, rule.basal_area_m2_per_ha) &&
                         rule.basal_area_m2_per_ha >= 0.0;
  if (is_target) return rule;
  throw UsageError(
      fmt::format("'{}' is not a rule: below=20 or above=20 (m2/ha that remain), or marked=COLUMN",
                  text),
      {.column = "`thinning`"});
}

Thinning thin(const Inventory& inventory, const StandReport& report, const ThinningRule& rule) {
  Thinning result{.is_removed = removed_trees(inventory, report, rule)};
  const auto figures = [&](const std::vector<std::size_t>& trees, double area_m2, int which) {
    std::vector<std::size_t> chosen;
    for (const std::size_t tree : trees) {
      if (which < 0 || result.is_removed[tree] == which) chosen.push_back(tree);
    }
    return stand_figures(inventory, chosen, area_m2, report.dominant_trees_per_ha);
  };
  const auto of = [&](std::string name, const std::vector<std::size_t>& trees, double area_m2) {
    return ThinningFigures{.name = std::move(name),
                           .before = figures(trees, area_m2, -1),
                           .removed = figures(trees, area_m2, 1),
                           .after = figures(trees, area_m2, 0)};
  };
  std::vector<std::size_t> all;
  double area_m2 = 0.0;
  for (const AreaReport& area : report.areas) {
    result.plots.push_back(of(area.area.name, area.area.trees, area.area.area_m2));
    all.insert(all.end(), area.area.trees.begin(), area.area.trees.end());
    area_m2 += area.area.area_m2;
  }
  result.all = of("", all, area_m2);
  return result;
}

}  // namespace silvafit::stand
