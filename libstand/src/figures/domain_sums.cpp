// SPDX-License-Identifier: MIT
#include "figures/domain_sums.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "figures/figure_sums.hpp"

namespace silvafit::stand {
namespace {

constexpr std::string_view kDiameter = "dbh";

/// Calls a function with each list of sums over plots.
void each_total(PlotSums& sums, const std::function<void(PlotTotals&)>& visit) {
  for (PlotTotals* const totals :
       {&sums.stems, &sums.basal_areas_m2, &sums.heights_m, &sums.stems_with_height}) {
    visit(*totals);
  }
  for (PlotTotals& totals : sums.quantities) visit(totals);
  for (PlotTotals& totals : sums.stems_with_quantity) visit(totals);
}

}  // namespace

void DomainSums::add(const Inventory& inventory,
                     const std::vector<SampledArea>& areas,
                     const std::function<data::TextColumn(const std::string& column)>& labels,
                     std::size_t plots) {
  std::vector<data::TextColumn> columns;
  for (const std::string& name : by_) {
    columns.push_back(name == kDiameter ? data::TextColumn() : labels(name));
  }
  for (std::size_t i = 0; i < areas.size(); ++i) {
    std::map<Key, SampledArea> parts;
    for (const std::size_t tree : areas[i].trees) {
      Key key;
      for (const data::TextColumn& column : columns) {
        if (column.size() == 0) {
          key.emplace_back(diameter_class(inventory.dbh_cm[tree], class_width_cm_), "");
        } else {
          key.emplace_back(0.0, column.is_missing(tree) ? "" : std::string(column[tree]));
        }
      }
      parts[key].trees.push_back(tree);
    }
    for (auto& [key, part] : parts) {
      part.area_m2 = areas[i].area_m2;
      PlotSums sums;
      sums.add(inventory, {part});
      Part& own = parts_[key].emplace_back(Part{.plot = plots + i, .trees = part.trees.size()});
      each_total(sums, [&own](PlotTotals& totals) { own.totals.push_back(totals.front()); });
    }
  }
}

std::vector<std::string> DomainSums::labels_of(const Key& key) const {
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < key.size(); ++i) {
    const auto& [number, label] = key[i];
    const bool is_class = by_[i] == kDiameter;
    labels.push_back(
        is_class ? fmt::format("{}-{}", number * class_width_cm_, (number + 1.0) * class_width_cm_)
                 : label);
  }
  return labels;
}

std::vector<DomainFigures> DomainSums::figures(
    PlotSums plots, const std::function<StratumFigures(const PlotSums&)>& estimate) const {
  std::vector<DomainFigures> result;
  for (const auto& [key, parts] : parts_) {
    std::ranges::fill(plots.trees, 0);
    each_total(plots, [](PlotTotals& totals) { std::ranges::fill(totals, 0.0); });
    for (const Part& part : parts) {
      plots.trees[part.plot] = part.trees;
      auto value = part.totals.begin();
      each_total(plots, [&](PlotTotals& totals) { totals[part.plot] = *value++; });
    }
    result.push_back({.labels = labels_of(key), .figures = estimate(plots)});
  }
  return result;
}

}  // namespace silvafit::stand
