// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "silvafit/base/json_text.hpp"
#include "silvafit/stand/species_table.hpp"
#include "silvafit/stand/window.hpp"
#include "silvafit/tree/packed_glb.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {

std::string base64(std::string_view bytes) {
  static constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0U;
  };
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::uint32_t three = byte(i) << 16U | byte(i + 1) << 8U | byte(i + 2);
    for (std::size_t k = 0; k < 4; ++k) {
      // A last group of one or two bytes has only two or three digits.
      const bool has_content = i + k <= bytes.size();
      text += has_content ? kDigits[three >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

namespace {

using nlohmann::ordered_json;

ordered_json rounded(double value, double per_unit) {
  if (!std::isfinite(value)) return nullptr;
  const double result = std::round(value * per_unit) / per_unit;
  return result == 0.0 ? 0.0 : result;  // no -0
}
/// Finer than the measurement of tree lengths.
ordered_json millimeters(double meters) { return rounded(meters, 1e3); }
ordered_json fine(double value) { return rounded(value, 1e6); }

ordered_json point(const tree::Position& at) {
  return {{"x", at.x_m}, {"y", at.y_m}, {"z", at.z_m}};
}

/// Distinct texts in order of decreasing number of trees, and the index of each tree's text.
struct Names {
  std::vector<std::string> names{};
  std::vector<std::size_t> of_tree{};
};

Names names_of(const ViewStand& stand, std::string ViewTree::*text) {
  std::map<std::string, std::size_t> counts;
  for (const ViewTree& tree : stand.trees) ++counts[tree.*text];
  Names result;
  for (const auto& [name, count] : counts) result.names.push_back(name);
  std::ranges::stable_sort(result.names, [&](const std::string& a, const std::string& b) {
    return counts[a] > counts[b];
  });
  std::map<std::string, std::size_t> numbers;
  for (std::size_t i = 0; i < result.names.size(); ++i) numbers[result.names[i]] = i;
  for (const ViewTree& tree : stand.trees) result.of_tree.push_back(numbers[tree.*text]);
  return result;
}

/// Plots in the order of their first tree.
Names plots_of(const ViewStand& stand) {
  Names result;
  std::map<std::string, std::size_t> numbers;
  for (const ViewTree& tree : stand.trees) {
    const auto [found, is_new] = numbers.emplace(tree.plot, result.names.size());
    if (is_new) result.names.push_back(tree.plot);
    result.of_tree.push_back(found->second);
  }
  return result;
}

/// The convex hull of a plot's stems; nothing if they are on a line.
ordered_json outline_of(const ViewStand& stand, const Names& plots, std::size_t plot) {
  std::vector<stand::Point> stems;
  for (std::size_t i = 0; i < stand.trees.size(); ++i) {
    const tree::Position& at = stand.trees[i].position;
    if (plots.of_tree[i] == plot) stems.push_back({at.x_m, at.y_m});
  }
  ordered_json outline = ordered_json::array();
  const auto hull = stand::Window::convex_hull(stems);
  if (!hull) return outline;
  const std::vector<stand::Polygon> polygons = hull->outline();
  for (const stand::Point& corner : polygons.front().outer) {
    outline.push_back({millimeters(corner.x), millimeters(corner.y)});
  }
  return outline;
}

template <typename Items, typename Value>
ordered_json column(const Items& items, Value value) {
  ordered_json list = ordered_json::array();
  for (const auto& item : items) list.push_back(value(item));
  return list;
}

/// The number or null.
ordered_json optional_number(const std::optional<std::size_t>& number) {
  return number ? ordered_json(*number) : ordered_json(nullptr);
}

ordered_json trees_json(const ViewStand& stand,
                        const Names& plots,
                        const Names& species,
                        const std::map<const tree::Builder*, std::size_t>& presets) {
  const stand::Layers layers;
  const auto each = [&](auto value) { return column(stand.trees, value); };
  ordered_json trees{
      {"plot", plots.of_tree},
      {"tree", each([](const ViewTree& tree) { return tree.tree; })},
      {"species", species.of_tree},
      {"preset", each([&](const ViewTree& tree) { return presets.at(tree.preset); })},
      {"x", each([](const ViewTree& tree) { return millimeters(tree.position.x_m); })},
      {"y", each([](const ViewTree& tree) { return millimeters(tree.position.y_m); })},
      {"z", each([](const ViewTree& tree) { return millimeters(tree.position.z_m); })},
      {"dbh", each([](const ViewTree& tree) { return millimeters(tree.dbh_cm); })}};
  trees["h"] = each([](const ViewTree& tree) { return millimeters(tree.observed.h_m); });
  trees["hcb"] = each([](const ViewTree& tree) { return millimeters(tree.observed.hcb_m); });
  trees["cw"] = each([](const ViewTree& tree) { return millimeters(tree.observed.cw_m); });
  trees["layer"] = each([&](const ViewTree& tree) -> ordered_json {
    if (!std::isfinite(tree.observed.h_m)) return nullptr;
    return layers.layer_of(tree.observed.h_m);
  });
  for (std::size_t k = 0; k < 4; ++k) {
    trees[std::string(1, "WMUC"[k])] =
        each([&](const ViewTree& tree) { return fine(tree.indices.at(k)); });
  }
  trees["core"] = each([](const ViewTree& tree) { return rounded(tree.core, 1.0); });
  trees["node"] = each([](const ViewTree& tree) { return optional_number(tree.node); });
  trees["number"] = each([](const ViewTree& tree) { return optional_number(tree.number); });
  return trees;
}

/// Numbers have six significant digits, as many as colors need.
ordered_json columns_json(const ViewStand& stand) {
  ordered_json columns = ordered_json::array();
  for (const ViewColumn& own : stand.columns) {
    columns.push_back(
        {{"name", own.name},
         {"texts", own.texts.empty() ? ordered_json(nullptr) : ordered_json(own.texts)},
         {"values", column(own.values, [](double value) -> ordered_json {
            if (!std::isfinite(value)) return nullptr;
            if (value == 0.0) return 0.0;
            const double digits = 5.0 - std::floor(std::log10(std::abs(value)));
            return std::abs(digits) < 300.0 ? rounded(value, std::pow(10.0, digits))
                                            : ordered_json(value);
          })}});
  }
  return columns;
}

/// Radii of all trees of a variant, or null if they are half the crown width in all directions.
ordered_json radii_json(const ViewVariant& variant) {
  const bool all_round = std::ranges::all_of(variant.trees, [](const ViewVersion& tree) {
    if (!tree.shape) return true;
    const tree::CrownRadii& radii = tree.shape->radii;
    return radii.east_m == radii.west_m && radii.east_m == radii.south_m &&
           radii.east_m == radii.north_m;
  });
  if (all_round) return nullptr;
  const auto each = [&](double tree::CrownRadii::*direction) {
    return column(variant.trees, [&](const ViewVersion& tree) {
      return tree.shape ? millimeters(tree.shape->radii.*direction) : ordered_json(nullptr);
    });
  };
  return {{"east", each(&tree::CrownRadii::east_m)},
          {"west", each(&tree::CrownRadii::west_m)},
          {"south", each(&tree::CrownRadii::south_m)},
          {"north", each(&tree::CrownRadii::north_m)}};
}

/// \param next  index of the first tree of this variant among those with a shape; is increased
ordered_json variant_json(const ViewVariant& variant, const ViewModels* models, std::size_t& next) {
  const auto size = [&](double ViewSizes::*which) {
    return column(variant.trees,
                  [&](const ViewVersion& tree) { return millimeters(tree.sizes.*which); });
  };
  ordered_json json{{"name", variant.name},
                    {"title", variant.title},
                    {"h", size(&ViewSizes::h_m)},
                    {"hcb", size(&ViewSizes::hcb_m)},
                    {"cw", size(&ViewSizes::cw_m)}};
  json["hc"] = column(variant.trees, [](const ViewVersion& tree) {
    return tree.shape ? millimeters(tree.shape->hc_m) : ordered_json(nullptr);
  });
  json["radii"] = radii_json(variant);
  ordered_json model = ordered_json::array();
  for (const ViewVersion& tree : variant.trees) {
    const bool is_drawn = models != nullptr && tree.shape;
    model.push_back(is_drawn ? ordered_json(models->shared.trees[next].model)
                             : ordered_json(nullptr));
    if (tree.shape) ++next;
  }
  json["model"] = std::move(model);
  return json;
}

ordered_json models_json(const ViewModels& models, const ViewOptions& options) {
  ordered_json shapes = ordered_json::array();
  for (const tree::SharedModel& model : models.shared.models) {
    const tree::Morphology& shape = model.morphology;
    const tree::CrownRadii& radii = shape.radii.value();
    shapes.push_back({{"preset", model.builder->name()},
                      {"h", shape.h_m},
                      {"hcb", shape.hcb_m},
                      {"hc", shape.hc_m.value()},
                      {"dbh", shape.dbh_cm},
                      {"radii",
                       {{"east", radii.east_m},
                        {"west", radii.west_m},
                        {"south", radii.south_m},
                        {"north", radii.north_m}}}});
  }
  return {{"levels", options.levels}, {"shapes", std::move(shapes)}, {"glb", base64(models.glb)}};
}

ordered_json preset_json(const tree::PresetHead& preset) {
  return {{"name", preset.name},
          {"title", preset.title},
          {"up", preset.crown_index.up},
          {"down", preset.crown_index.down},
          {"leaf", preset.leaf},
          {"bark", preset.bark.color}};
}

}  // namespace

std::string view_json(const ViewStand& stand,
                      const ViewDrawing& drawing,
                      const ViewOptions& options) {
  const Names plots = plots_of(stand);
  const Names species = names_of(stand, &ViewTree::species);
  std::map<const tree::Builder*, std::size_t> presets;
  ordered_json preset_list = ordered_json::array();
  for (const ViewTree& tree : stand.trees) {
    if (!presets.emplace(tree.preset, presets.size()).second) continue;
    preset_list.push_back(preset_json(tree.preset->preset()));
  }
  const stand::Layers layers;
  ordered_json layer_names = ordered_json::array();
  for (std::size_t i = 0; i < layers.count(); ++i) layer_names.push_back(layers.name_of(i));
  ordered_json plot_list = ordered_json::array();
  for (std::size_t plot = 0; plot < plots.names.size(); ++plot) {
    plot_list.push_back({{"name", plots.names[plot]}, {"outline", outline_of(stand, plots, plot)}});
  }
  ordered_json variants = ordered_json::array();
  std::size_t next = 0;
  for (const ViewVariant& variant : stand.variants) {
    variants.push_back(variant_json(variant, drawing.models, next));
  }
  const ordered_json json{
      {"schema", "silvafit-view/1"},
      {"silvafit", options.version},
      {"title", options.title},
      {"notes", stand.notes},
      {"origin", point(drawing.origin)},
      {"species", species.names},
      {"layers", layer_names},
      {"layer_bounds", layers.bounds_m},
      {"presets", preset_list},
      {"plots", plot_list},
      {"trees", trees_json(stand, plots, species, presets)},
      {"columns", columns_json(stand)},
      {"variants", variants},
      {"models",
       drawing.models == nullptr ? ordered_json(nullptr) : models_json(*drawing.models, options)},
      {"scene",
       drawing.scene.empty() ? ordered_json(nullptr)
                             : ordered_json(base64(tree::deflated(drawing.scene)))}};
  return json_text(json);
}

}  // namespace silvafit::study
