// SPDX-License-Identifier: MIT

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "view/view_stand.hpp"

namespace silvafit::study {
namespace {

/// Files store positions to a millimeter, tables often to a centimeter; stems are farther apart.
constexpr double kSameMeters = 0.05;

struct PlanPoint {
  double x_m = 0.0;
  double y_m = 0.0;
};

/// x east, y up, z south in the scene.
PlanPoint place_of(const tree::ReadInstance& instance, const tree::Position& origin) {
  return {origin.x_m + instance.transform[12], origin.y_m - instance.transform[14]};
}

bool is_same(const PlanPoint& place, const tree::Position& position) {
  return std::hypot(place.x_m - position.x_m, place.y_m - position.y_m) <= kSameMeters;
}

bool is_drawn(const ViewStand& stand, std::size_t tree) {
  return std::ranges::any_of(stand.variants, [tree](const ViewVariant& variant) {
    return variant.trees[tree].shape.has_value();
  });
}

/// Trees of a table by position.
class Places {
 public:
  explicit Places(const ViewStand& stand) : stand_(stand) {
    for (std::size_t i = 0; i < stand.trees.size(); ++i) {
      const tree::Position& at = stand.trees[i].position;
      cells_[cell_of({at.x_m, at.y_m})].push_back(i);
    }
  }

  std::vector<std::size_t> at(const PlanPoint& place) const {
    std::vector<std::size_t> trees;
    const auto [column, row] = cell_of(place);
    for (std::int64_t i = column - 1; i <= column + 1; ++i) {
      for (std::int64_t k = row - 1; k <= row + 1; ++k) {
        const auto found = cells_.find({i, k});
        if (found == cells_.end()) continue;
        for (const std::size_t tree : found->second) {
          if (is_same(place, stand_.trees[tree].position)) trees.push_back(tree);
        }
      }
    }
    return trees;
  }

 private:
  static std::int64_t cell_at(double coordinate_m) {
    constexpr double kMost = 1e15;  // a scene of another program may have any coordinates
    return std::llround(std::clamp(coordinate_m / kSameMeters, -kMost, kMost));
  }
  static std::pair<std::int64_t, std::int64_t> cell_of(const PlanPoint& place) {
    return {cell_at(place.x_m), cell_at(place.y_m)};
  }

  const ViewStand& stand_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>> cells_{};
};

class Matcher {
 public:
  Matcher(ViewStand& stand, const tree::ReadScene& scene) : stand_(stand), scene_(scene) {
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) nodes_.emplace(scene.nodes[i].name, i);
    for (const tree::ReadInstance& instance : scene.instances) {
      named_.emplace(instance.name, &instance);
      // A tree has at most one instance of its model per material.
      if (instance.tree >= 0.0)
        numbered_.emplace(static_cast<std::size_t>(instance.tree), &instance);
    }
  }

  void match() {
    match_nodes();
    match_instances();
    const auto found = static_cast<std::size_t>(std::ranges::count_if(
        stand_.trees, [](const ViewTree& tree) { return tree.node || tree.number; }));
    const std::size_t here = numbered_.size();
    refuse_others(found, here);
    if (found < stand_.trees.size()) {
      const std::size_t missing = stand_.trees.size() - found;
      stand_.notes.push_back(fmt::format("{} of {} of the table {} not in the scene.",
                                         missing,
                                         counted(stand_.trees.size(), "tree", "trees"),
                                         missing == 1 ? "is" : "are"));
    }
    if (placed_ < here) {
      const std::size_t missing = here - placed_;
      stand_.notes.push_back(fmt::format(
          "{} of {} of the scene {} not in the table, or not unique by {} no measurements.",
          missing,
          counted(here, "tree", "trees"),
          missing == 1 ? "is" : "are",
          missing == 1 ? "position; it has" : "position; they have"));
    }
  }

 private:
  void match_nodes() {
    for (ViewTree& tree : stand_.trees) {
      const std::string name = tree.plot + "-" + tree.tree;
      const auto node = nodes_.find(name);
      const auto instance = named_.find(name);
      if (node == nodes_.end() || instance == named_.end()) continue;
      if (instance->second->tree >= 0.0) continue;
      if (is_same(place_of(*instance->second, scene_.origin), tree.position)) {
        tree.node = node->second;
      } else {
        ++elsewhere_;
      }
    }
  }

  void match_instances() {
    const Places places(stand_);
    std::vector<std::size_t> grown;  // a tree's number counts grown trees only
    for (std::size_t i = 0; i < stand_.trees.size(); ++i) {
      if (is_drawn(stand_, i)) grown.push_back(i);
    }
    std::map<std::size_t, std::vector<std::size_t>> numbers_of_tree;
    for (const auto& [number, instance] : numbered_) {
      const std::vector<std::size_t> trees = places.at(place_of(*instance, scene_.origin));
      if (trees.size() == 1) numbers_of_tree[trees.front()].push_back(number);
      if (trees.size() > 1 && numbered_.size() == grown.size() && number < grown.size() &&
          std::ranges::find(trees, grown[number]) != trees.end()) {
        numbers_of_tree[grown[number]].push_back(number);
      }
    }
    for (const auto& [tree, numbers] : numbers_of_tree) {
      if (numbers.size() > 1) continue;
      stand_.trees[tree].number = numbers.front();
      ++placed_;
    }
  }

  void refuse_others(std::size_t found, std::size_t here) const {
    if (found == 0) {
      throw InputError(elsewhere_ + here == 0
                           ? "no tree of the table is in the scene; nodes are named plot-tree"
                           : "no tree of the table has the position of a tree of the scene; use "
                             "the table, plots and coordinates from which the scene was grown");
    }
    if (2 * placed_ < std::min(here, stand_.trees.size())) {
      throw InputError(
          fmt::format("only {} of the {} trees of the scene {} found in the table by position; use "
                      "the table, plots and coordinates from which the scene was grown",
                      placed_,
                      here,
                      placed_ == 1 ? "is" : "are"));
    }
  }

  ViewStand& stand_;
  const tree::ReadScene& scene_;
  std::unordered_map<std::string, std::size_t> nodes_{};
  std::unordered_map<std::string, const tree::ReadInstance*> named_{};
  std::map<std::size_t, const tree::ReadInstance*> numbered_{};
  std::size_t placed_ = 0;
  std::size_t elsewhere_ = 0;
};

/// Gives the trees of a table their nodes and instances in the scene. A node is found by its name
/// plot-tree, an instance by its position; both must have the position of the tree in the table,
/// within 5 cm in x and y, so that measurements of other trees are never shown. An instance that
/// matches more than one tree by position gets that of its number if it is one of them, and else
/// none; a tree that matches more than one instance gets none. Notes count trees without a match.
/// \throws InputError if no tree is found, or fewer instances than half the scene's or the table's
/// trees, whichever are fewer
void match_trees(ViewStand& stand, const tree::ReadScene& scene) { Matcher(stand, scene).match(); }

using nlohmann::json;

/// A page cannot load other files, so everything must be in the file.
void check_self_contained(const json& description) {
  for (const char* kind : {"buffers", "images"}) {
    if (!description.contains(kind)) continue;
    for (const json& item : description[kind]) {
      const std::string uri = item.value("uri", "");
      if (!uri.empty() && !uri.starts_with("data:")) {
        throw InputError("the scene needs the file " + uri +
                         " in the same folder; a page can contain a single GLB file only");
      }
    }
  }
}

double number(const json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : data::kMissing;
}

/// x east, y up, z south in the scene.
tree::Position position_of(const std::array<double, 16>& transform, const tree::Position& origin) {
  return {origin.x_m + transform[12], origin.y_m - transform[14], origin.z_m + transform[13]};
}

std::optional<tree::TreeShape> shape_of(const ViewTree& tree, const json& extras) {
  tree::Morphology morphology{.plot = tree.plot,
                              .tree = tree.tree,
                              .dbh_cm = tree.dbh_cm,
                              .h_m = tree.observed.h_m,
                              .hcb_m = tree.observed.hcb_m,
                              .cw_m = tree.observed.cw_m};
  if (const auto radii = extras.find("radii"); radii != extras.end() && radii->is_object()) {
    morphology.radii = tree::CrownRadii{
        number(*radii, "e"), number(*radii, "w"), number(*radii, "s"), number(*radii, "n")};
  }
  try {
    return tree.preset->shape_of(morphology);
  } catch (const DomainError&) {
    return std::nullopt;  // another program may have written the numbers
  }
}

const tree::Builder& preset_named(const std::string& name,
                                  const std::string& species,
                                  const tree::BuilderCatalogue& catalogue) {
  for (const tree::BuilderKind kind : all_values<tree::BuilderKind>()) {
    for (const tree::Builder* builder : catalogue.of(kind)) {
      if (builder->name() == name) return *builder;
    }
  }
  return builder_of(species, catalogue);
}

/// Trees with their measurements.
ViewStand stand_of_extras(const json& description,
                          const tree::ReadScene& read,
                          const tree::BuilderCatalogue& catalogue) {
  ViewStand stand;
  ViewVariant variant{.name = "scene", .title = "As in the file"};
  std::size_t without = 0;
  const json& nodes = description.value("nodes", json::array());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!read.nodes[i].is_shown) continue;
    const json& extras = nodes[i].value("extras", json::object());
    if (!extras.is_object() || !extras.contains("tree") || !extras.contains("h")) continue;
    const auto text = [&](const char* name) {
      const auto found = extras.find(name);
      if (found == extras.end()) return std::string();
      return found->is_string() ? found->get<std::string>() : found->dump();
    };
    ViewTree tree{.plot = text("plot"),
                  .tree = text("tree"),
                  .species = text("species"),
                  .preset = &preset_named(text("preset"), text("species"), catalogue),
                  .position = position_of(read.nodes[i].transform, read.origin),
                  .dbh_cm = number(extras, "dbh"),
                  .observed = {number(extras, "h"), number(extras, "hcb"), number(extras, "cw")},
                  .node = i};
    std::optional<tree::TreeShape> shape = shape_of(tree, extras);
    if (!shape) {
      ++without;
      continue;
    }
    variant.trees.push_back({.sizes = tree.observed, .shape = std::move(shape)});
    stand.trees.push_back(std::move(tree));
  }
  if (without > 0) {
    stand.notes.push_back(fmt::format("{} of {} of the file {} shown without measurements.",
                                      without,
                                      counted(without + stand.trees.size(), "tree", "trees"),
                                      without == 1
                                          ? "is dead wood or has impossible sizes; it is"
                                          : "are dead wood or have impossible sizes; they are"));
  }
  stand.variants.push_back(std::move(variant));
  return stand;
}

/// Trees of a scene without measurements: instances with a number, and in files of this program the
/// other nodes except the ground. Nodes of other files are unknown.
std::size_t count_unmeasured(const json& description, const tree::ReadScene& scene) {
  const json::json_pointer generator("/asset/generator");
  const bool is_own = description.contains(generator) && description[generator] == "silvafit";
  std::set<double> numbers;
  std::set<std::string> names;
  for (const tree::ReadInstance& instance : scene.instances) {
    if (instance.tree >= 0.0) {
      numbers.insert(instance.tree);
    } else if (is_own && instance.name != "ground") {
      names.insert(instance.name);
    }
  }
  return numbers.size() + names.size();
}

std::string note_without_measurements(std::size_t trees) {
  if (trees == 0) {
    return "The file has no measurements of trees, so there is no list of trees.";
  }
  return fmt::format(
      "The file has {} without measurements, so there is no list of trees; give the table from "
      "which {} grown with `trees=FILE.csv` to add {} measurements.",
      counted(trees, "tree", "trees"),
      trees == 1 ? "it was" : "they were",
      trees == 1 ? "its" : "their");
}

/// Nodes that an animation hides have scale 0 and are not among the instances.
void check_drawable(const tree::ReadScene& scene) {
  const bool has_triangles = std::ranges::any_of(scene.models, [](const tree::ReadModel& model) {
    return std::ranges::any_of(
        model.parts, [](const tree::ReadPart& part) { return !part.mesh.indices.empty(); });
  });
  if (has_triangles && scene.triangle_count() == 0) {
    throw InputError("nothing to show: all nodes of the scene are scaled to 0");
  }
  for (const tree::ReadInstance& instance : scene.instances) {
    if (!tree::is_flattened(instance.transform)) continue;
    throw InputError("the node '" + instance.name + "' is scaled to 0 in one direction");
  }
}

}  // namespace

SceneTrees trees_of_scene(std::string_view glb,
                          const data::Table* table,
                          const tree::BuilderCatalogue& catalogue,
                          const ViewOptions& options) {
  const json description = tree::glb_description(glb);
  try {
    check_self_contained(description);
    // Rejects files that the page cannot draw.
    const tree::ReadScene read = tree::read_glb(glb);
    check_drawable(read);
    SceneTrees scene{.origin = read.origin};
    if (table == nullptr) {
      scene.stand = stand_of_extras(description, read, catalogue);
      if (scene.stand.trees.empty()) {
        scene.unmeasured = count_unmeasured(description, read);
        scene.stand.notes.push_back(note_without_measurements(scene.unmeasured));
      }
    } else {
      scene.stand = read_view_stand(*table, catalogue, options);
      match_trees(scene.stand, read);
    }
    return scene;
  } catch (const json::exception&) {
    throw InputError(
        "cannot read the GLB file: a value in its JSON part has another type than glTF requires; "
        "export the scene again");
  }
}

}  // namespace silvafit::study
