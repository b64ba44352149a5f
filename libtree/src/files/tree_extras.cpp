// SPDX-License-Identifier: MIT
#include <cmath>
#include <nlohmann/json.hpp>

#include "silvafit/base/json_text.hpp"
#include "silvafit/tree/scene_writer.hpp"

namespace silvafit::tree {
namespace {

using nlohmann::ordered_json;

/// Vertices are floats: digits beyond these are their rounding.
double rounded(double value) {
  constexpr double kSteps = 1e5;
  return std::round(kSteps * value) / kSteps;
}

ordered_json json_of(const CrownRadii& radii) {
  return {{"e", rounded(radii.east_m)},
          {"w", rounded(radii.west_m)},
          {"s", rounded(radii.south_m)},
          {"n", rounded(radii.north_m)}};
}

}  // namespace

std::string tree_extras(const SceneTree& tree) {
  ordered_json extras{{"plot", tree.plot},
                      {"tree", tree.tree},
                      {"species", tree.species},
                      {"preset", tree.preset},
                      {"h", rounded(tree.measured.h_m)},
                      {"hcb", rounded(tree.measured.hcb_m)},
                      {"dbh", rounded(tree.measured.dbh_cm)},
                      {"cw", rounded(tree.measured.radii.width_m())},
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
