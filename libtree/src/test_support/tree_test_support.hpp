// SPDX-License-Identifier: MIT
// Common data of the tests of this library: the catalogue, trees of the paper, random trees.
#pragma once

#include <string>
#include <string_view>

#include "reference.hpp"
#include "silvafit/base/error.hpp"
#include "silvafit/base/random.hpp"
#include "silvafit/tree/scene.hpp"

namespace silvafit::test {

inline const tree::PresetCatalogue& shipped_presets() {
  static const tree::PresetCatalogue catalogue = tree::PresetCatalogue::load(source_file("models"));
  return catalogue;
}

inline const tree::BuilderCatalogue& shipped_builders() {
  static const tree::BuilderCatalogue catalogue =
      tree::BuilderCatalogue::load(source_file("models"));
  return catalogue;
}

/// Shoots with a picture of those that ship.
inline tree::LeafyShoots shoots_of(double length_m, double leaf_area_index) {
  return {.picture = shipped_presets().named("schima-superba").leafy_shoots.picture,
          .length_m = length_m,
          .leaf_area_index = leaf_area_index};
}

/// The path of an error in a file of the catalogue; for a missing or unknown key, that of the key.
inline std::string path_of(const InputError& error) {
  constexpr std::string_view kMark = "key \"";
  const std::string& path = error.place().column;
  const std::size_t at = error.message().find(kMark);
  if (at == std::string::npos) return path;
  const std::string key = error.message().substr(at + kMark.size());
  return (path.empty() ? "" : path + ".") + key.substr(0, key.find('"'));
}

/// Tree 1 of the Chinese fir plot in the segment-model paper (its Table II).
inline tree::Morphology paper_tree_1() {
  return {.plot = "1",
          .tree = "1",
          .species = "Cunninghamia lanceolata",
          .dbh_cm = 28.1,
          .h_m = 20.2,
          .hcb_m = 5.8,
          .hc_m = 8.8,
          .radii = tree::CrownRadii{2.1, 2.5, 1.5, 2.4}};
}

/// Random trees that pass validate(), with many extreme ones: just above breast height, crowns that
/// start at the ground or right below the tip, crowns wider than the tree is high, very thin and
/// very thick stems.
inline tree::Morphology random_morphology(Random& random, int number) {
  tree::Morphology tree{.plot = "p", .tree = std::to_string(number)};
  const auto one_in = [&random](int n) { return random.below(static_cast<std::uint64_t>(n)) == 0; };
  tree.h_m = one_in(4) ? 1.3 + random.uniform(1e-6, 0.5) : random.uniform(1.5, 50.0);
  tree.hcb_m = one_in(4) ? 0.0 : tree.h_m * random.uniform(0.0, 0.95);
  if (one_in(6)) tree.hcb_m = tree.h_m - random.uniform(0.01, 0.1);
  tree.dbh_cm = one_in(4) ? random.uniform(0.1, 1.0) : random.uniform(1.0, 150.0);
  const auto radius = [&] {
    return one_in(3) ? random.uniform(0.05, 0.3) : random.uniform(0.3, 9.0);
  };
  if (one_in(2)) {
    tree.radii = tree::CrownRadii{radius(), radius(), radius(), radius()};
  } else {
    tree.cw_m = 2.0 * radius();
  }
  if (one_in(2)) tree.hc_m = tree.hcb_m + random.uniform(0.0, 1.0) * (tree.h_m - tree.hcb_m);
  if (one_in(8)) tree.hc_m = one_in(2) ? tree.hcb_m : tree.h_m;
  if (one_in(3)) tree.age_years = random.uniform(1.0, 60.0);
  return tree;
}

/// The stages before the mesh, for one tree.
struct Stages {
  tree::TreeShape shape;
  tree::Crown crown;
  tree::Skeleton skeleton;
};

inline Stages stages_of(const tree::Morphology& morphology,
                        const tree::Preset& preset,
                        std::uint64_t seed = 1) {
  tree::TreeShape shape = tree::complete(morphology, preset.relative_hc, preset.name);
  tree::Crown crown(shape, preset.crown_index);
  Random random = tree::random_of_tree(seed, morphology.plot, morphology.tree);
  tree::Skeleton skeleton = tree::grow_skeleton(shape, crown, preset, random);
  return {std::move(shape), std::move(crown), std::move(skeleton)};
}

}  // namespace silvafit::test
