// SPDX-License-Identifier: MIT
#include "view/view_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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
  for (const tree::BuilderKind kind : tree::builder_kinds()) {
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
    stand.notes.push_back(fmt::format(
        "{} of {} of the file {} shown without measurements.",
        without,
        counted(without + stand.trees.size(), "tree", "trees"),
        without == 1 ? "has impossible sizes; it is" : "have impossible sizes; they are"));
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
