// SPDX-License-Identifier: MIT
#include <cmath>
#include <string>
#include <vector>

#include "report/report_json.hpp"
#include "silvafit/base/json_values.hpp"
#include "silvafit/stand/species_table.hpp"

namespace silvafit::study {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostTrees = 20000;

/// Rounds positions to the millimeter, which is finer than they are measured.
ordered_json millimeters(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::round(value * 1e3) / 1e3;
}

ordered_json ring(const std::vector<stand::Point>& corners) {
  ordered_json list = ordered_json::array();
  for (const stand::Point& corner : corners) {
    list.push_back({millimeters(corner.x), millimeters(corner.y)});
  }
  return list;
}

ordered_json rings_of(const stand::Window& window) {
  ordered_json rings = ordered_json::array();
  for (const stand::Polygon& polygon : window.outline()) {
    rings.push_back(ring(polygon.outer));
    for (const auto& hole : polygon.holes) rings.push_back(ring(hole));
  }
  return rings;
}

/// There is a map of each window, or of each plot without windows.
ordered_json areas_of(const stand::Inventory& inventory, const stand::PlotWindows& windows) {
  ordered_json areas = ordered_json::array();
  const auto add = [&areas](const std::string& name, ordered_json rings) {
    areas.push_back({{"name", text_or_null(name)}, {"rings", std::move(rings)}});
  };
  if (windows.domains.empty()) {
    for (const std::string& plot : inventory.plot.levels()) add(plot, ordered_json::array());
  }
  for (const stand::Domain& domain : windows.domains) add(domain.name, rings_of(domain.window));
  return areas;
}

ordered_json names_of_layers() {
  const stand::Layers layers;
  ordered_json names = ordered_json::array();
  for (std::size_t i = 0; i < layers.count(); ++i) names.push_back(layers.name_of(i));
  return names;
}

/// The data of the trees on the page, column by column.
class TreeColumns {
 public:
  TreeColumns(const stand::Inventory& inventory, const stand::StructuralUnits& units)
      : inventory_(inventory), units_(units) {}

  void add_to(ordered_json& map) const;

 private:
  template <class Value>
  ordered_json column(Value value) const {
    ordered_json list = ordered_json::array();
    for (std::size_t tree = 0; tree < inventory_.size(); ++tree) list.push_back(value(tree));
    return list;
  }
  ordered_json measure(const std::vector<double>& values) const {
    return column(
        [&](std::size_t tree) { return values.empty() ? nullptr : number_or_null(values[tree]); });
  }
  ordered_json area_of(std::size_t tree) const;
  ordered_json neighbors_of(std::size_t tree) const;

  const stand::Inventory& inventory_;
  const stand::StructuralUnits& units_;
};

ordered_json TreeColumns::area_of(std::size_t tree) const {
  if (units_.windows.domains.empty()) return inventory_.plot.code(tree);
  const auto domain = units_.windows.domain_of_plot[inventory_.plot.code(tree)];
  return domain ? ordered_json(*domain) : ordered_json(nullptr);
}

ordered_json TreeColumns::neighbors_of(std::size_t tree) const {
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < units_.neighbors; ++i) {
    const std::uint32_t neighbor = units_.nearest[tree * units_.neighbors + i];
    if (neighbor != stand::kNoTree) list.push_back(neighbor);
  }
  return list;
}

void TreeColumns::add_to(ordered_json& map) const {
  const stand::Layers layers;
  map["area"] = column([this](std::size_t tree) { return area_of(tree); });
  map["plot"] = column([this](std::size_t tree) { return std::string(inventory_.plot[tree]); });
  map["tree"] = column([this](std::size_t tree) { return std::string(inventory_.tree[tree]); });
  map["species"] = column([this](std::size_t tree) {
    return inventory_.species.is_missing(tree) ? ordered_json(nullptr)
                                               : ordered_json(inventory_.species.code(tree));
  });
  map["x"] = column([this](std::size_t tree) { return millimeters(inventory_.x[tree]); });
  map["y"] = column([this](std::size_t tree) { return millimeters(inventory_.y[tree]); });
  map["dbh"] = measure(inventory_.dbh_cm);
  map["h"] = measure(inventory_.h_m);
  map["cw"] = measure(inventory_.cw_m);
  map["layer"] = column([&](std::size_t tree) {
    const std::size_t layer =
        layers.layer_of(inventory_.h_m.empty() ? std::nan("") : inventory_.h_m[tree]);
    return layer < layers.count() ? ordered_json(layer) : ordered_json(nullptr);
  });
  map["core"] = column([this](std::size_t tree) { return units_.core[tree] != 0 ? 1 : 0; });
  map["W"] = measure(units_.W);
  map["M"] = measure(units_.M);
  map["U"] = measure(units_.U);
  map["C"] = measure(units_.C);
  map["nearest"] = column([this](std::size_t tree) { return neighbors_of(tree); });
}

}  // namespace

std::optional<ordered_json> report_map(const StudyRecord& record) {
  const stand::Inventory& inventory = record.inventory.inventory;
  if (!record.units || inventory.size() == 0 || inventory.size() > kMostTrees) return std::nullopt;
  ordered_json map{{"areas", areas_of(inventory, record.units->windows)},
                   {"buffer", record.units->buffer_m},
                   {"torus", record.units->edge == stand::EdgeCorrection::kTorus},
                   {"species_names", inventory.species.levels()},
                   {"layer_names", names_of_layers()}};
  TreeColumns(inventory, *record.units).add_to(map);
  return map;
}

}  // namespace silvafit::study
