// SPDX-License-Identifier: MIT
#include "view/view_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "silvafit/base/error.hpp"
#include "silvafit/base/text.hpp"
#include "silvafit/tree/scene_reader.hpp"
#include "view/view_match.hpp"
#include "view/view_table.hpp"

namespace silvafit::study {
namespace {

using nlohmann::json;

constexpr std::size_t kHeader = 20;  // of the file and of its first chunk

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

/// The description of a GLB file; the page reads its buffers.
json description_of(std::string_view glb) {
  if (glb.size() < kHeader || glb.substr(0, 4) != "glTF" || word_at(glb, 4) != 2 ||
      glb.substr(16, 4) != "JSON" || word_at(glb, 12) > glb.size() - kHeader) {
    throw InputError("not a GLB file (binary glTF 2.0)");
  }
  json description = json::parse(glb.substr(kHeader, word_at(glb, 12)), nullptr, false);
  if (!description.is_object()) throw InputError("not a GLB file: its JSON part is not valid JSON");
  return description;
}

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

tree::Position origin_of(const json& description) {
  const json::json_pointer place("/scenes/0/extras/origin");
  if (!description.contains(place)) return {};
  const json& origin = description[place];
  const auto coordinate = [&](const char* name) {
    const double value = number(origin, name);
    return std::isfinite(value) ? value : 0.0;
  };
  return {coordinate("x"), coordinate("y"), coordinate("z")};
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
    return tree::complete(morphology, tree.preset->relative_hc, tree.preset->name);
  } catch (const DomainError&) {
    return std::nullopt;  // another program may have written the numbers
  }
}

const tree::Preset& preset_named(const std::string& name,
                                 const std::string& species,
                                 const tree::PresetCatalogue& catalogue) {
  for (const tree::Preset& preset : catalogue.presets()) {
    if (preset.name == name) return preset;
  }
  return preset_or_fallback(species, catalogue);
}

/// The visible nodes: those of the scene with a mesh at or below them, unless a scale of 0 hides
/// it, as for past stages of an animated tree.
class ShownNodes {
 public:
  explicit ShownNodes(const json& description)
      : nodes_(description.value("nodes", json::array())), shown_(nodes_.size(), false) {
    const json scenes = description.value("scenes", json::array());
    const auto scene = description.value("scene", std::size_t{0});
    if (scene >= scenes.size()) return;
    for (const json& root : scenes[scene].value("nodes", json::array())) {
      visit(root.get<std::size_t>());
    }
  }

  bool operator[](std::size_t node) const { return shown_[node]; }

 private:
  static bool is_hidden(const json& node) {
    const auto scale = node.find("scale");
    return scale != node.end() && std::all_of(scale->begin(), scale->end(), [](const json& factor) {
             return factor.get<double>() == 0.0;
           });
  }

  /// Parents before their children, without recursion, because nesting may be deep.
  void visit(std::size_t root) {
    std::vector<std::pair<std::size_t, std::size_t>>
        reached;  // nodes, and the positions of parents
    if (!is_hidden(nodes_[root])) reached.emplace_back(root, 0);
    for (std::size_t k = 0; k < reached.size(); ++k) {
      const json& node = nodes_[reached[k].first];
      for (const json& child : node.value("children", json::array())) {
        const auto index = child.get<std::size_t>();
        if (!is_hidden(nodes_[index])) reached.emplace_back(index, k);
      }
    }
    for (std::size_t k = reached.size(); k-- > 0;) {
      const auto [node, parent] = reached[k];
      if (nodes_[node].contains("mesh")) shown_[node] = true;
      if (shown_[node]) shown_[reached[parent].first] = true;
    }
  }

  json nodes_;
  std::vector<bool> shown_;
};

/// Trees with their measurements.
ViewStand stand_of_extras(const json& description,
                          const tree::ReadScene& read,
                          const tree::Position& origin,
                          const tree::PresetCatalogue& catalogue) {
  ViewStand stand;
  ViewVariant variant{.name = "scene", .title = "As in the file"};
  std::size_t without = 0;
  const json& nodes = description.value("nodes", json::array());
  const ShownNodes shown(description);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!shown[i]) continue;
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
                  .position = position_of(read.nodes[i], origin),
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
    stand.notes.push_back(fmt::format(
        "{} of {} of the file {} shown without measurements.",
        without,
        counted(without + stand.trees.size(), "tree", "trees"),
        without == 1 ? "has impossible sizes; it is" : "have impossible sizes; they are"));
  }
  stand.variants.push_back(std::move(variant));
  return stand;
}

std::vector<std::string> node_names(const json& description) {
  std::vector<std::string> names;
  for (const json& node : description.value("nodes", json::array())) {
    names.push_back(node.value("name", ""));
  }
  return names;
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

/// Checks that nodes form trees, so that traversal terminates.
void check_hierarchy(const json& description) {
  const json& nodes = description.value("nodes", json::array());
  std::vector<int> parents(nodes.size(), 0);
  const auto count = [&](const json& list) {
    for (const json& index : list) {
      const auto node = index.get<std::size_t>();
      if (node >= parents.size()) throw InputError(fmt::format("nodes[{}] does not exist", node));
      if (++parents[node] > 1) {
        throw InputError(fmt::format("nodes[{}] has two parents, or is its own descendant", node));
      }
    }
  };
  for (const json& node : nodes) count(node.value("children", json::array()));
  const json& scenes = description.value("scenes", json::array());
  const auto shown = description.value("scene", std::size_t{0});
  if (shown < scenes.size()) count(scenes[shown].value("nodes", json::array()));
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
                          const tree::PresetCatalogue& catalogue,
                          const ViewOptions& options) {
  const json description = description_of(glb);
  try {
    check_self_contained(description);
    check_hierarchy(description);
    // Rejects files that the page cannot draw.
    const tree::ReadScene read = tree::read_glb(glb);
    check_drawable(read);
    SceneTrees scene{.origin = origin_of(description)};
    if (table == nullptr) {
      scene.stand = stand_of_extras(description, read, scene.origin, catalogue);
      if (scene.stand.trees.empty()) {
        scene.unmeasured = count_unmeasured(description, read);
        scene.stand.notes.push_back(note_without_measurements(scene.unmeasured));
      }
    } else {
      scene.stand = read_view_stand(*table, catalogue, options);
      match_trees(scene.stand, node_names(description), read);
    }
    return scene;
  } catch (const json::exception&) {
    throw InputError(
        "cannot read the GLB file: a value in its JSON part has another type than glTF requires; "
        "export the scene again");
  }
}

}  // namespace silvafit::study
