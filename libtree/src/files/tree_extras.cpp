// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "silvafit/base/json_text.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const CrownRadii& radii) {
  return {{"e", radii.east_m}, {"w", radii.west_m}, {"s", radii.south_m}, {"n", radii.north_m}};
}

}  // namespace

std::string tree_extras(const SceneTree& tree) {
  ordered_json extras{{"plot", tree.plot},
                      {"tree", tree.tree},
                      {"species", tree.species},
                      {"preset", tree.preset},
                      {"h", tree.measured.h_m},
                      {"hcb", tree.measured.hcb_m},
                      {"dbh", tree.measured.dbh_cm},
                      {"cw", tree.measured.radii.width_m()},
                      {"radii", json_of(tree.measured.radii)}};
  if (tree.removed_share) extras["removed_share"] = *tree.removed_share;
  if (!tree.notes.empty()) {
    ordered_json notes = ordered_json::array();
    for (const Note& note : tree.notes) notes.push_back(note.about + ": " + note.text);
    extras["notes"] = std::move(notes);
  }
  return json_text(extras);
}

}  // namespace silvafit::tree
